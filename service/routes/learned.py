"""What the filter has learned of a robot, over REST: live and of a recording, and as a vehicle's version."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query
from fastapi.responses import Response

from omnimate.service.calls import Call, Operating, Reading
from omnimate.service.errors import UnavailableError
from omnimate.service.idempotency import Answer
from omnimate.service.learned import Learned, accept_learned, learned_view
from omnimate.service.problems import documented
from omnimate.service.routes.common import ALWAYS, IfMatch, etag, expected_version
from omnimate.service.routes.recordings import RecordingId
from omnimate.service.routes.vehicles import Vehicle, vehicle_view
from omnimate.service.store.rows import find_row
from omnimate.service.store.tables import RecordingRow

if TYPE_CHECKING:
    from sqlalchemy.orm import Session as Db

    from omnimate.ipec.filter.forward import Estimate
    from omnimate.ipec.tracker import Tracker
    from omnimate.vehicle.recording import Recording

router = APIRouter(prefix="/v1", tags=["learned"], responses=ALWAYS)
Uncalibrated = Annotated[
    bool, Query(description="Whether the vehicle holds nominal values, so that more of them may be wrong.")
]


@router.get("/robot/learned", operation_id="getLearned")
def get_learned(call: Reading) -> Learned:
    """Return what the filter has learned of the robot on the bus since its parameters were taken."""
    tracker = _tracker(call)
    with call.components.database.reading() as db:
        return learned_view(db, tracker.vehicle, tracker.slow, tracker.findings)


@router.post(
    "/robot/learned/accept",
    operation_id="acceptLearned",
    response_model=Vehicle,
    responses=documented(412, 428),
)
def accept(call: Operating, if_match: IfMatch) -> Response:
    """Make what was learned of the robot on the bus the newest version of its vehicle."""
    tracker = _tracker(call)
    expected = expected_version(if_match)

    def act(db: Db) -> Answer:
        row = accept_learned(db, tracker.vehicle, tracker.slow, "learned on the way", expected)
        return Answer(vehicle_view(row), 200, {"ETag": etag(row.version)})

    response = call.change(None, act)
    call.components.robot.reload()
    return response


@router.get("/recordings/{recording_id}/learned", operation_id="getLearnedOfRecording")
def get_learned_of_recording(
    recording_id: RecordingId, call: Reading, uncalibrated: Uncalibrated = False
) -> Learned:
    """Return what the filter has learned of its robot by the end of a recording."""
    recording, estimate = _estimate(call, recording_id, uncalibrated=uncalibrated)
    with call.components.database.reading() as db:
        return learned_view(db, recording.vehicle, estimate.slow, estimate.findings)


@router.post(
    "/recordings/{recording_id}/learned/accept",
    operation_id="acceptLearnedOfRecording",
    response_model=Vehicle,
    responses=documented(412, 428),
)
def accept_of_recording(
    recording_id: RecordingId, call: Operating, if_match: IfMatch, uncalibrated: Uncalibrated = False
) -> Response:
    """Make what the filter has learned by the end of a recording the newest version of its vehicle."""
    expected, accepted = expected_version(if_match), []

    def act(db: Db, learned: tuple[Recording, Estimate]) -> Answer:
        recording, estimate = learned
        accepted.append(recording.vehicle.name)
        origin = f"learned from recording {recording_id}"
        row = accept_learned(db, recording.vehicle, estimate.slow, origin, expected)
        return Answer(vehicle_view(row), 200, {"ETag": etag(row.version)})

    response = call.compute_and_change(
        None, lambda: _estimate(call, recording_id, uncalibrated=uncalibrated), act
    )
    if call.components.vehicle in accepted:
        call.components.robot.reload()
    return response


def _tracker(call: Call) -> Tracker:
    """Return the tracker of the robot on the bus.

    Raises:
        UnavailableError: there is none, or it has not taken a sample.
    """
    tracker = call.components.robot.observer.tracker
    if tracker is None or not tracker.started:
        raise UnavailableError(
            "the filter does not follow the robot: it needs two trucks, a linkage that is read, and half a "
            "minute after the first start on a machine"
        )
    return tracker


def _estimate(call: Call, recording_id: str, *, uncalibrated: bool) -> tuple[Recording, Estimate]:
    """Return a recording of the database and the filter's estimate of it.

    Raises:
        NotFoundError: there is no such recording.
        NoLinkageError: its robot has a single truck.
        LinkageChannelError: a channel of the linkage was never read, or stood still while it must move.
    """
    from omnimate.ipec.filter.estimate import estimate
    from omnimate.ipec.filter.prior import CALIBRATED, NOMINAL

    with call.components.database.reading() as db:
        row = find_row(db, RecordingRow, recording_id)
    recording = call.components.recordings.load(row)
    return recording, estimate(recording, prior=NOMINAL if uncalibrated else CALIBRATED)
