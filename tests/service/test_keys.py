"""Keys and callers on a database, without a service."""

from types import SimpleNamespace

import pytest

from omnimate.service import access
from omnimate.service.access import LOCAL, Caller, Callers, add_key, caller_of, keys, revoke_key
from omnimate.service.errors import AuthenticationError, NotFoundError
from omnimate.service.store.database import Database
from omnimate.service.store.tables import KeyRow


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    """An SQLite database."""
    opened = Database(f"sqlite:///{tmp_path_factory.mktemp('keys')}/service.db")
    yield opened
    opened.close()


@pytest.fixture
def database(opened):
    """The database without any key."""
    with opened.writing() as db:
        db.query(KeyRow).delete()
    return opened


@pytest.fixture
def now(monkeypatch):
    """A clock that a test sets."""
    clock = SimpleNamespace(now=100.0)
    replacement = SimpleNamespace(monotonic=lambda: clock.now, time=lambda: clock.now)
    monkeypatch.setattr(access, "time", replacement)
    return clock


def new_key(database, role="read"):
    """Add a key; return its id and its Authorization header."""
    with database.writing() as db:
        key = add_key(db, role, role)
    return key.split("_")[1], f"Bearer {key}"


def identify(database, authorization, *, keyless_allowed=False):
    with database.reading() as db:
        return caller_of(db, authorization, keyless_allowed=keyless_allowed)


@pytest.mark.parametrize("role", ["read", "operate"])
def test_a_key_identifies_its_caller_and_role(database, role):
    identity, authorization = new_key(database, role)
    assert identify(database, authorization) == Caller(identity, role, role)
    assert identify(database, authorization.replace("Bearer", "bearer")) == Caller(identity, role, role)


def test_a_role_that_is_not_known_may_only_read(database):
    identity, authorization = new_key(database)
    with database.writing() as db:
        db.get(KeyRow, identity).role = "unknown"
    assert identify(database, authorization).role == "read"


def test_without_a_key_a_caller_is_local_only_where_allowed_and_before_the_first_key(database):
    assert identify(database, None, keyless_allowed=True) == LOCAL == Caller("local", "operate")
    with pytest.raises(AuthenticationError, match="needs a key"):
        identify(database, None)
    new_key(database)
    with pytest.raises(AuthenticationError, match="needs a key"):
        identify(database, None, keyless_allowed=True)


def test_a_key_with_another_scheme_prefix_id_or_secret_is_not_known(database):
    identity, authorization = new_key(database)
    _, other = new_key(database)
    secret_of_other = other.split("_", 2)[2]
    for wrong in (
        authorization.replace("Bearer", "Basic"),
        authorization.replace("omk_", "key_"),
        authorization.replace(identity, "00000000"),
        f"Bearer omk_{identity}_{secret_of_other}",
        f"Bearer omk_{identity}_",
        *("Bearer ", "Bearer omk_", "Bearer omk_00000000_x", "Bearer x", "Bearer omk_é"),
    ):
        with pytest.raises(AuthenticationError, match="not known"):
            identify(database, wrong)


def test_a_secret_has_32_bytes_and_an_id_eight_hexadecimal_digits(database):
    identity, authorization = new_key(database)
    assert len(bytes.fromhex(identity)) == 4
    assert len(authorization.split("_", 2)[2]) == 43  # 32 bytes in base64


def test_a_key_stays_revoked_since_the_first_time_and_does_not_make_keys_unnecessary(database, now):
    identity, authorization = new_key(database)
    for _ in range(2):
        with database.writing() as db:
            assert revoke_key(db, identity).revoked == 100.0
        now.now += 5.0
    with pytest.raises(AuthenticationError, match="revoked"):
        identify(database, authorization)
    with pytest.raises(AuthenticationError, match="needs a key"):
        identify(database, None, keyless_allowed=True)
    with database.writing() as db, pytest.raises(NotFoundError):
        revoke_key(db, "00000000")


def test_keys_are_listed_from_the_oldest(database, now):
    added = []
    for _ in range(4):
        added.append(new_key(database)[0])
        now.now += 1.0
    with database.reading() as db:
        assert [row.id for row in keys(db)] == added


def test_a_caller_is_remembered_for_less_than_the_age_that_is_asked_for(database, now):
    identity, authorization = new_key(database)
    callers = Callers(keyless_allowed=False)
    assert callers.remembered(authorization, float("inf")) is None
    callers.identify(database, authorization)
    now.now += 1.0
    assert callers.remembered(authorization, 1.5) == Caller(identity, "read", "read")
    assert callers.remembered(authorization, 1.0) is None


def test_calls_with_a_key_that_was_revoked_are_answered_for_a_second_at_most():
    assert 0.0 < access.REMEMBERED_TIME <= 1.0


def test_a_refused_caller_is_forgotten(database):
    identity, authorization = new_key(database)
    callers = Callers(keyless_allowed=False)
    callers.identify(database, authorization)
    with database.writing() as db:
        revoke_key(db, identity)
    for _ in range(2):
        with pytest.raises(AuthenticationError, match="revoked"):
            callers.identify(database, authorization)
        assert callers.remembered(authorization, float("inf")) is None


@pytest.mark.parametrize("keyless_allowed", [True, False])
def test_callers_without_a_key_are_as_the_service_allows(database, keyless_allowed):
    callers = Callers(keyless_allowed=keyless_allowed)
    if keyless_allowed:
        assert callers.identify(database, None) == LOCAL
    else:
        with pytest.raises(AuthenticationError, match="needs a key"):
            callers.identify(database, None)


def test_the_callers_that_were_identified_longest_ago_are_forgotten(database, monkeypatch):
    """A key in use stays known, so that it stops the robot also while the database is away."""
    monkeypatch.setattr(access, "REMEMBERED_CALLERS", 2)
    first, second, third = [new_key(database)[1] for _ in range(3)]
    callers = Callers(keyless_allowed=False)
    for header in (first, second, first, third):
        callers.identify(database, header)
    remembered = [callers.remembered(header, float("inf")) is not None for header in (first, second, third)]
    assert remembered == [True, False, True]
