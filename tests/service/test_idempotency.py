"""Idempotency-Key: a request that is repeated with the same key is carried out once, and answered alike."""

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import pytest
from fastapi import FastAPI
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel
from sqlalchemy.exc import IntegrityError, OperationalError

from omnimate.service import calls
from omnimate.service.access import LOCAL, Caller
from omnimate.service.calls import MAX_KEY_LENGTH, Answer, Call, act_once, digest_of, storable
from omnimate.service.errors import AuthenticationError, ForbiddenError, StateError
from omnimate.service.store.database import Database
from omnimate.service.store.tables import AnswerRow


class Content(BaseModel):
    """The content of a test's answers."""

    number: int


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    """An SQLite database without a service."""
    opened = Database(f"sqlite:///{tmp_path_factory.mktemp('answers')}/service.db")
    yield opened
    opened.close()


FEW = st.sampled_from("ab")
REQUESTS = st.lists(st.tuples(FEW, FEW, FEW, FEW), min_size=1, max_size=12)


def unanswered(caller, key, call, digest):
    return AnswerRow(caller=caller, key=key, call=call, digest=digest)


def forget_all(database):
    with database.writing() as db:
        db.query(AnswerRow).delete()


@settings(max_examples=40)
@given(requests=REQUESTS)
def test_a_key_stands_for_its_first_request_and_for_no_other(database, requests):
    forget_all(database)
    first, acted = {}, []
    for number, request in enumerate(requests):

        def act(_db, number=number):
            acted.append(number)
            return Answer(Content(number=number), 201, {"Location": f"/{number}"})

        key = request[:2]
        if key in first and first[key][0] != request:
            with pytest.raises(StateError, match="used for another request"):
                act_once(database, unanswered(*request), act)
            continue
        response = act_once(database, unanswered(*request), act)
        original = first.setdefault(key, (request, number))[1]
        assert response.body == Content(number=original).model_dump_json().encode()
        assert (response.status_code, response.headers["Location"]) == (201, f"/{original}")
        assert ("Idempotency-Replayed" in response.headers) == (original != number)
    assert acted == [number for _, number in first.values()]


def test_a_request_that_failed_may_be_sent_again_with_its_key(database):
    request = "local", "key", "POST /", digest_of(None)

    def fail(_db):
        raise StateError("not now")

    with pytest.raises(StateError, match="not now"):
        act_once(database, unanswered(*request), fail)
    assert act_once(database, unanswered(*request), lambda _db: Answer(Content(number=1))).status_code == 200


@given(key=st.text(min_size=1, max_size=600))
def test_every_key_fits_into_the_table_and_equal_keys_stay_equal(key):
    assert 0 < len(storable(key)) <= MAX_KEY_LENGTH
    assert storable(key) == storable(key)


@given(bodies=st.lists(st.binary(max_size=20), min_size=2, max_size=2, unique=True))
def test_different_bodies_have_different_digests(bodies):
    assert digest_of(bodies[0]) != digest_of(bodies[1])


def test_of_two_equal_requests_at_once_one_is_carried_out_and_both_are_answered_alike(database, monkeypatch):
    """The other one is stored between the look-up and the own row, as two services do it."""
    forget_all(database)
    request = "local", "key", "POST /", digest_of(None)
    act_once(database, unanswered(*request), lambda _db: Answer(Content(number=1), 201))
    found = [None, calls.replayed]

    def late(db, wanted):
        look = found.pop(0)
        return look and look(db, wanted)

    monkeypatch.setattr(calls, "replayed", late)
    response = act_once(database, unanswered(*request), lambda _db: pytest.fail("carried out twice"))
    assert (response.body, response.status_code) == (Content(number=1).model_dump_json().encode(), 201)
    monkeypatch.setattr(calls, "replayed", lambda _db, _request: None)
    with pytest.raises(IntegrityError):
        act_once(database, unanswered(*request), lambda _db: Answer(Content(number=2), 201))


@pytest.fixture
def call(database):
    """A call of a program on this machine, without a key."""
    forget_all(database)
    return Call(SimpleNamespace(database=database), LOCAL, None, "POST /v1/things")


def number_of(response):
    return Content.model_validate_json(response.body).number


def test_without_a_key_each_request_is_carried_out(call):
    numbers = iter(range(3))
    answers = [call.change(None, lambda _db: Answer(Content(number=next(numbers)))) for _ in range(3)]
    assert [number_of(answer) for answer in answers] == [0, 1, 2]


def test_what_a_repeated_request_needs_is_not_computed_again(call):
    call, computed = replace(call, key="key"), []

    def compute():
        computed.append(len(computed))
        return computed[-1]

    for _ in range(2):
        answer = call.compute_and_change(b"body", compute, lambda _db, number: Answer(Content(number=number)))
        assert number_of(answer) == 0
    assert computed == [0]
    with pytest.raises(StateError):
        call.compute_and_change(b"another body", compute, lambda _db, number: Answer(Content(number=number)))
    assert computed == [0]


def test_a_key_belongs_to_its_caller_its_call_and_its_body(call):
    call = replace(call, key="key")
    assert number_of(call.change(b"a", lambda _db: Answer(Content(number=1)))) == 1
    with pytest.raises(StateError):
        replace(call, name="POST /v1/others").change(b"a", lambda _db: Answer(Content(number=2)))
    other = replace(call, caller=Caller("another", "operate"))
    assert number_of(other.change(b"a", lambda _db: Answer(Content(number=3)))) == 3


def test_only_a_caller_who_may_operate_changes_anything_and_its_key_is_kept(call):
    changing = asyncio.run(calls._operating(call, "key"))
    assert changing == replace(call, key=storable("key"))
    assert asyncio.run(calls._operating(call, None)) == call
    assert asyncio.run(calls._operating(call, "")) == call
    with pytest.raises(ForbiddenError, match="may only read"):
        asyncio.run(calls._operating(replace(call, caller=Caller("visitor", "read")), "key"))


@pytest.mark.parametrize("remembered", [None, LOCAL])
def test_a_caller_that_is_not_remembered_is_identified_by_the_database(call, remembered):
    asked = []

    def identify(database, authorization):
        asked.append((database, authorization))
        return LOCAL

    callers = SimpleNamespace(remembered=lambda _authorization, _age: remembered, identify=identify)
    components = SimpleNamespace(database=call.components.database, callers=callers)
    app = SimpleNamespace(state=SimpleNamespace(components=components))
    request = SimpleNamespace(app=app, method="POST", url=SimpleNamespace(path="/v1/things", query=""))
    for reading in (calls._reading, calls._stopping):
        assert asyncio.run(reading(request, "Bearer x")) == Call(
            components, LOCAL, None, "POST /v1/things", "Bearer x"
        )
    assert asked == ([] if remembered else [(components.database, "Bearer x")] * 2)
    request.url.query = "name=A"
    whole = Call(components, LOCAL, None, "POST /v1/things?name=A", "Bearer x")
    assert asyncio.run(calls._reading(request, "Bearer x")) == whole


def test_the_table_holds_the_longest_key_that_stays_as_it_is():
    assert AnswerRow.__table__.c.key.type.length == MAX_KEY_LENGTH
    assert storable("k" * MAX_KEY_LENGTH) == "k" * MAX_KEY_LENGTH
    assert len(storable("k" * (MAX_KEY_LENGTH + 1))) <= MAX_KEY_LENGTH


def test_authorization_is_no_parameter_of_a_call_in_openapi():
    """OpenAPI ignores such a parameter: it has security schemes for it."""
    app = FastAPI()

    @app.get("/things")
    def things(call: calls.Reading) -> str:
        return call.name

    assert "parameters" not in app.openapi()["paths"]["/things"]["get"]


@pytest.mark.parametrize(
    ("answer", "is_allowed"),
    [
        pytest.param(LOCAL, True, id="its key is valid"),
        pytest.param(AuthenticationError("revoked"), False, id="its key was revoked"),
        pytest.param(OperationalError("", (), ConnectionError()), True, id="the database does not answer"),
    ],
)
def test_a_long_call_goes_on_unless_its_key_was_revoked(database, answer, is_allowed):
    def identify(_database, authorization):
        assert authorization == "Bearer key"
        if isinstance(answer, Exception):
            raise answer
        return answer

    components = SimpleNamespace(callers=SimpleNamespace(identify=identify), database=database)
    assert Call(components, LOCAL, None, "GET /", "Bearer key").is_still_allowed() is is_allowed
