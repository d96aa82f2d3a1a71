"""A whole UMBmark by the generated client: the service drives its robot, solves, and accepts.

Usage: python 06_fleet_client.py URL [SIDE] [RUNS]; OMNIMATE_KEY holds a key where the service asks for one.
"""

import os
import sys
import time

from omnimate_client import AuthenticatedClient, Client
from omnimate_client.api.umbmark import accept_result, get_session, solve_session, start_session
from omnimate_client.models import Accept, SessionStart, Solve


def main(url: str, side: float = 4.0, runs: int = 5) -> None:
    """Calibrate the robot that a service has on its bus."""
    key = os.environ.get("OMNIMATE_KEY")
    client = AuthenticatedClient(url, key) if key else Client(url)
    started = SessionStart.from_dict({"how": "drive", "side": side, "runs": runs})
    session = start_session.sync(client=client, body=started)
    while session.state == "driving":
        print(session.detail)
        time.sleep(1.0)
        session = get_session.sync(session.id, client=client)
    if session.state != "collecting":
        sys.exit(f"the robot did not drive to the end: {session.detail}")
    result = solve_session.sync(session.id, client=client, body=Solve())
    for name, truck in result.trucks.additional_properties.items():
        before, after = 1e3 * truck.errors.e_max_syst, 1e3 * truck.errors.after
        wheelbase = 1e3 * truck.calibrated.wheelbase
        print(f"truck {name}: E_max,syst {before:.1f} mm -> {after:.1f} mm, wheelbase {wheelbase:.2f} mm")
    accepted = accept_result.sync(session.id, client=client, body=Accept(), if_match=result.revision)
    print(accepted.detail)


if __name__ == "__main__":
    main(sys.argv[1], *(kind(text) for kind, text in zip((float, int), sys.argv[2:], strict=False)))
