"""`omnimate serve` and `omnimate key`: without the extra `service`, and keys from making to revoking."""

import re

import pytest

from omnimate.cli import serve


@pytest.fixture
def without_fastapi(monkeypatch):
    """An installation without the extra."""
    monkeypatch.setattr(serve, "find_spec", lambda name: None if name == "fastapi" else object())


@pytest.mark.parametrize(
    "arguments", [("serve",), ("key", "add", "hall"), ("key", "list"), ("key", "revoke", "0")]
)
def test_without_the_extra_a_sentence_says_how_to_install_it(omnimate, without_fastapi, arguments):
    result = omnimate(*arguments)
    assert (result.code, result.out) == (1, "")
    assert "the service needs fastapi: pip install 'omnimate[service]'" in result.err


def test_a_key_is_made_listed_and_revoked(omnimate, tmp_path):
    database = ("--database", f"sqlite:///{tmp_path}/service.db")
    key = omnimate("key", "add", "hall", "--role", "operate", *database).out.strip()
    identity = re.fullmatch(r"omk_([0-9a-f]{8})_\S+", key)[1]
    listed = omnimate("key", "list", *database).out
    assert identity in listed
    assert key not in listed
    assert omnimate("key", "revoke", identity, *database).code == 0
    refused = omnimate("key", "revoke", "0000", *database)
    assert (refused.code, "there is no key '0000'" in refused.err) == (1, True)
