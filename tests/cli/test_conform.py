"""`omnimate conform`: what a device does not do is told, and the exit code says whether there is anything."""

import json

from omnimate.vcan_sim.reference import reference_vehicle

NODE = reference_vehicle().encoders[0].node


def test_a_device_that_does_all_is_told_line_by_line(accepted, simulated):
    result = accepted("conform", "--bus", "virtual://x", "--node", NODE, "--most", "reads", "--timeout", 0.02)
    assert "CiA 301  1018h identity                  passed" in result.out.splitlines()
    assert " 0 failed" in result.err


def test_what_a_device_does_not_do_is_told_with_what_was_found(omnimate, local_node):
    call = ("conform", "--bus", "virtual://x", "--node", 1, "--most", "reads", "--timeout", 0.02)
    result = omnimate(*call)
    assert result.code == 1
    assert "SDO request of 4 bytes          failed  a request of 4 bytes was answered" in result.out
    rows = json.loads(omnimate(*call, "--json").out)
    assert {row["outcome"] for row in rows} == {"passed", "failed", "absent"}
    assert rows[0]["demand"] == "1000h is there, 4 bytes long."


def test_a_node_that_is_not_there_is_one_sentence(refused, local_node):
    assert "no answer to SDO about 1000h:00" in refused(
        "conform", "--bus", "virtual://x", "--node", 99, "--timeout", 0.02, out=""
    )
