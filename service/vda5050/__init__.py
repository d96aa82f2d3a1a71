"""The robot for fleet managers, by VDA 5050 2.1 over MQTT: connection, state, factsheet."""
