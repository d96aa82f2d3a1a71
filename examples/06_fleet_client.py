"""A whole UMBmark by the Python client: the service drives its robot, solves, and accepts.

Usage: python 06_fleet_client.py URL [SIDE] [RUNS]; OMNIMATE_KEY holds a key where the service asks for one.
"""

import os
import sys
import time

from omnimate.client import Client


def main(url: str, side: float, runs: int) -> None:
    """Calibrate the robot that a service has on its bus."""
    umbmark = Client(url, os.environ.get("OMNIMATE_KEY")).umbmark
    session = umbmark.start_session(how="drive", side=side, runs=runs)
    while session["state"] == "driving":
        print(session["detail"])
        time.sleep(1.0)
        session = umbmark.get_session(session["id"])
    if session["state"] != "collecting":
        sys.exit(f"the robot did not drive to the end: {session['detail']}")
    result = umbmark.solve_session(session["id"])
    for name, truck in result["trucks"].items():
        before, after = 1e3 * truck["errors"]["e_max_syst"], 1e3 * truck["errors"]["after"]
        wheelbase = 1e3 * truck["calibrated"]["wheelbase"]
        print(f"truck {name}: E_max,syst {before:.1f} mm -> {after:.1f} mm, wheelbase {wheelbase:.2f} mm")
    print(umbmark.accept_result(session["id"], if_match=result["revision"])["detail"])


if __name__ == "__main__":
    side = float(sys.argv[2]) if len(sys.argv) > 2 else 4.0
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    main(sys.argv[1], side, runs)
