"""The noise of floor and sensors, estimated from recordings, and the filter that makes it white."""
