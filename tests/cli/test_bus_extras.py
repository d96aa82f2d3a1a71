"""`--bus`: an interface whose library is missing names the extra that installs it."""

import pytest


@pytest.mark.parametrize("verb", [("dump",), ("scan",), ("record", "out"), ("monitor", "--seconds", "1")])
def test_udp_multicast_without_msgpack_names_its_extra(omnimate, monkeypatch, tmp_path, verb):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("can.interfaces.udp_multicast.utils.msgpack", None)
    result = omnimate(*verb, "--bus", "udp_multicast://239.74.163.2?port=43117")
    assert result.code == 1
    assert "pip install 'omnimate[multicast]'" in result.err
