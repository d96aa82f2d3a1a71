"""Idempotency-Key: a request that is repeated with the same key is carried out once, and answered alike."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel

from omnimate.service.calls import (
    MAX_KEY_LENGTH,
    Answer,
    act_once,
    digest_of,
    storable_key,
    unanswered,
)
from omnimate.service.errors import StateError
from omnimate.service.store.tables import AnswerRow


class Content(BaseModel):
    """The content of a test's answers."""

    number: int


FEW = st.sampled_from("ab")
REQUESTS = st.lists(st.tuples(FEW, FEW, FEW, FEW), min_size=1, max_size=12)


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
    assert 0 < len(storable_key(key)) <= MAX_KEY_LENGTH
    assert storable_key(key) == storable_key(key)


@given(bodies=st.lists(st.binary(max_size=20), min_size=2, max_size=2, unique=True))
def test_different_bodies_have_different_digests(bodies):
    assert digest_of(bodies[0]) != digest_of(bodies[1])
