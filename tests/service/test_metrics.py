"""Metrics for Prometheus: each count is that of what it counts."""

from prometheus_client.parser import text_string_to_metric_families

from tests.service.conftest import away, started, until


def metrics(client):
    """Return the samples of all metrics by name and labels."""
    text = client.get("/metrics").text
    families = text_string_to_metric_families(text)
    return {
        (sample.name, *sorted(sample.labels.values())): sample.value
        for family in families
        for sample in family.samples
    }


def test_calls_are_counted_by_operation_and_status(client):
    def count(operation, status):
        return metrics(client).get(("omnimate_call_seconds_count", status, "GET", operation), 0.0)

    before = count("listVehicles", "200"), count("getVehicle", "404"), count("other", "404")
    for _ in range(3):
        client.get("/v1/vehicles")
    client.get("/v1/vehicles/none")
    client.get("/v1/none")
    after = count("listVehicles", "200"), count("getVehicle", "404"), count("other", "404")
    assert [new - old for new, old in zip(after, before, strict=True)] == [3, 1, 1]


def test_sessions_are_counted_by_state(client):
    def count(state):
        return metrics(client).get(("omnimate_sessions", state), 0.0)

    before = count("collecting"), count("aborted")
    started(client)
    client.post(f"{started(client)}/abort")
    assert (count("collecting") - before[0], count("aborted") - before[1]) == (1.0, 1.0)


def test_the_robot_is_measured_also_while_the_database_is_away(client, monkeypatch):
    assert metrics(client)["omnimate_database_up",] == 1.0
    monkeypatch.setattr(client.components.database, "reading", away)
    assert client.get("/metrics").status_code == 200
    values = metrics(client)
    assert (values["omnimate_database_up",], values["omnimate_bus_up",]) == (0.0, 1.0)
    assert not {name for name, *_ in values} & {"omnimate_sessions", "omnimate_jobs"}


def test_the_bus_and_each_of_its_nodes_are_counted(client):
    def wellness(values):
        return [values.get(("omnimate_node_well", str(node))) for node in range(1, 8)]

    until(lambda: len(client.get("/v1/bus").json()["nodes"]) == 11)
    until(lambda: wellness(metrics(client)) == [1.0] * 7)
    values = metrics(client)
    assert values["omnimate_bus_up",] == 1.0
    assert values["omnimate_samples_total",] <= client.get("/v1/robot").json()["samples"]
    assert values["omnimate_frames_total",] > values["omnimate_samples_total",]
