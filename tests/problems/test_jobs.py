"""The jobs in problems/jobs: each loads, asks for good practice, and is answered with a proof."""

from __future__ import annotations

from pathlib import Path

import pytest
from thorough import THOROUGH, drawn

import uwopt
from uwopt.mission.mission import load_mission
from uwopt.results.design import AS_CENTRAL

JOBS = Path(__file__).parents[2] / "problems" / "jobs"
NAMES = sorted(path.stem for path in JOBS.glob("*.yaml"))
SOME_CAMERAS = ["avt-alvium-1800-c-040m", "avt-alvium-1800-c-234m"]  # among which the best of all lies
README = (JOBS / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_a_job_loads_asks_for_good_practice_and_is_listed(name: str) -> None:
    mission = load_mission(JOBS / f"{name}.yaml")
    assert mission.practice == "recommended"
    assert mission.requirements.snr_at == "worst" and mission.reserve.snr_db > 0
    assert f"| `{name}.yaml` |" in README
    head = (JOBS / f"{name}.yaml").read_text(encoding="utf-8").split("name:")[0]
    assert "# assumed: everything below" in head


def test_the_page_of_signatures_tells_of_every_mission() -> None:
    page = (JOBS.parents[1] / "docs" / "signed.md").read_text(encoding="utf-8")
    missions = [path.stem for path in JOBS.parent.glob("*.yaml") if not path.stem.endswith(".system")]
    told = [*missions, *(f"jobs/{name}" for name in NAMES)]
    assert [name for name in told if f"| `{name}` |" not in page] == []


@pytest.mark.parametrize("name", drawn(["plankton"], NAMES))
def test_a_job_is_answered_with_what_was_asked_for(name: str) -> None:
    mission = load_mission(JOBS / f"{name}.yaml")
    if not THOROUGH:
        mission = mission.with_changes(catalog=mission.to_dict()["catalog"] | {"cameras": SOME_CAMERAS})
    result = uwopt.solve(mission, quick=True)
    assert result.status in ("optimal", "feasible") and result.certificate is not None
    assert result.certificate.adds_up()
    best = result.recommendation
    assert best is not None and best.feasible
    assert AS_CENTRAL not in [warning.code for warning in best.warnings]  # there is time to count where nobody gave one
    for scene in best.scenes:
        assert scene.figures["snr_db_p05"] >= mission.requirements.min_snr_db - 1e-6
