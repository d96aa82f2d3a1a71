"""The event stream: every client gets every event in order, and of an object only its last state."""

import asyncio
import json
import threading

from omnimate.service.event_stream import QUEUED_EVENTS, EventStream


def events_in(text):
    """Return kind and content of the events in a part of a stream."""
    lines = [event.split("\n") for event in text.decode().split("\n\n") if event]
    return [(kind.removeprefix("event: "), json.loads(data.removeprefix("data: "))) for kind, data in lines]


def read(publish, clients=1):
    """Return what each client reads of a stream to which `publish` publishes, until it is closed."""

    async def client(stream):
        return [event async for part in stream.listen() for event in events_in(part)]

    async def run():
        stream = EventStream()
        stream.open(asyncio.get_running_loop())
        tasks = [asyncio.create_task(client(stream)) for _ in range(clients)]
        await asyncio.sleep(0)  # the clients listen
        thread = threading.Thread(target=publish, args=(stream,))
        thread.start()
        thread.join()  # holds the loop up, so that all events are gathered
        await asyncio.sleep(0)  # the loop hears of them
        await stream._sending
        stream.close()
        return await asyncio.gather(*tasks)

    return asyncio.run(run())


def test_every_client_reads_every_event_in_order():
    def publish(stream):
        stream.publish("job", {"id": "1"})
        stream.publish("job", {"id": "2"})
        stream.publish("session", {"id": "1"})

    expected = [("job", {"id": "1"}), ("job", {"id": "2"}), ("session", {"id": "1"})]
    assert read(publish, clients=3) == [expected] * 3


def test_of_one_object_only_the_last_state_is_sent():
    def publish(stream):
        for progress in range(5):
            stream.publish("job", {"id": "1", "progress": progress})

    assert read(publish) == [[("job", {"id": "1", "progress": 4})]]


def test_an_announced_object_is_read_once_however_often_it_changes():
    reads = []

    def publish(stream):
        for _ in range(5):
            stream.announce("session", "1", lambda identity: reads.append(identity) or {"id": identity})

    assert read(publish) == [[("session", {"id": "1"})]]
    assert reads == ["1"]


def test_an_event_that_cannot_be_made_does_not_keep_the_others_back(caplog):
    def fail(identity):
        raise OSError(identity)

    def publish(stream):
        stream.announce("session", "lost", fail)
        stream.publish("job", {"id": "1"})

    assert read(publish) == [[("job", {"id": "1"})]]
    assert "the event session of lost was not sent" in caplog.text


def test_a_new_client_first_gets_the_last_state_and_the_last_nodes():
    async def run():
        stream = EventStream()
        for kind in ("state", "nodes", "job"):
            stream.publish(kind, {"number": 1})
        stream.publish("state", {"number": 2})
        listening = stream.listen()
        first = [await anext(listening) for _ in range(2)]
        await listening.aclose()
        return [event for part in first for event in events_in(part)], stream.listeners

    assert asyncio.run(run()) == ([("state", {"number": 2}), ("nodes", {"number": 1})], 0)


def test_a_client_that_does_not_read_loses_the_oldest_events():
    async def run():
        stream = EventStream()
        listening = stream.listen()
        waiting = asyncio.ensure_future(anext(listening))
        await asyncio.sleep(0)
        for number in range(QUEUED_EVENTS + 10):
            stream._send(str(number).encode())
        first = await waiting
        stream._send(None)
        rest = [part async for part in listening]
        return first, rest

    first, rest = asyncio.run(run())
    assert (first, rest[-1]) == (b"10", str(QUEUED_EVENTS + 9).encode())


def test_a_client_that_reads_no_more_is_no_reader():
    async def run():
        stream = EventStream()
        assert not stream.has_readers
        client = stream.listen()
        first = asyncio.create_task(anext(client))
        await asyncio.sleep(0)  # the client listens
        for _ in range(QUEUED_EVENTS - 1):
            stream._send(b"event")
        assert (await first, stream.has_readers) == (b"event", True)
        for _ in range(2):
            stream._send(b"event")
        assert (stream.listeners, stream.has_readers) == (1, False)
        await anext(client)
        assert stream.has_readers

    asyncio.run(run())
