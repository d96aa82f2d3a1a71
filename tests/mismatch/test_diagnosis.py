"""What a diagnosis says of its fit."""

from omnimate.mismatch.diagnosis import USUAL_FACTOR, Change, Fit


def test_only_unusual_noise_is_reported_with_its_unit():
    usual = {"waviness [m/sqrt(m)]": 1e-4, "link [m]": 1e-4, "position [1]": 1.0}
    found = {
        "waviness [m/sqrt(m)]": 2.0 * USUAL_FACTOR * 1e-4,
        "link [m]": 1.01e-4,
        "position [1]": 0.25 / USUAL_FACTOR,
    }
    fit = Fit("", Change(1.0, 1.0), Change(1.0, 1.0), noise=found, usual_noise=usual)
    waviness, position = fit.unusual_noise
    assert waviness == (
        f"waviness {found['waviness [m/sqrt(m)]']:.2g} m/sqrt(m), {2.0 * USUAL_FACTOR:.2g} times the usual"
    )
    assert position == f"position {found['position [1]']:.2g} times the sigma that the poses state"
