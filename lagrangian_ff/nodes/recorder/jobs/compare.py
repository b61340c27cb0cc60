"""The service ~/compare: where the model fails on the last recording."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.nodes.common.status import Level, Status, errors_of
from lagrangian_ff.nodes.recorder.jobs import base
from lagrangian_ff.nodes.recorder.session import Result, new_path
from lagrangian_ff.progress import Progress, part

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.where import Compared

REGIONS = 8
"""Sentences shown about where a model fails; the page has all."""
OUT_OF_RANGE = 0.05
"""Share of a motion outside the identified range from which on it is a warning."""


@dataclass(frozen=True, kw_only=True)
class Compare(base.Job):
    """Compare a model with a recording."""

    service, doing, title = "compare", "comparing", "comparison"

    @classmethod
    def request(cls, given: base.Situation) -> "Compare":
        """Return the request for the present model and the last recording."""
        last = given.session.bags[-1]
        return cls(
            **given.common,
            model_file=str(given.present_model),
            bags=(str(last),),
            output=str(new_path(given.directory, f"{last.name}_{cls.service}", ".json")),
        )

    def summary(self) -> str:
        return f"started to compare {Path(self.model_file).name} with {base.names_of(self.bags)}"

    def work(self, progress: Progress) -> Result:
        """Write JSON and page, and return the error of each joint and where it lies."""
        from lagrangian_ff.diagnosis import compare
        from lagrangian_ff.diagnosis.where import Compared, locate
        from lagrangian_ff.recording import concatenate
        from lagrangian_ff.report import compare_page

        model = self.open_model()
        whole = concatenate(self.read_for(model, self.bags, part(progress, 0.0, 0.1)))
        comparison = compare(model, whole, progress=part(progress, 0.1, 0.5), intervals=True)
        where = locate(model, comparison, progress=part(progress, 0.5, 0.95))
        found = Compared(self.model_file, self.bags, where)
        progress(0.95, "writing the page")
        files = base.write_findings(self.output, found.record(), compare_page, found)
        return self.result(found, files)

    def result(self, found: "Compared", files: Mapping[str, str]) -> Result:
        """Return what is shown of the comparison and of the files that were written."""
        words, outside = found.where.words(), found.where.comparison.outside
        score = found.where.comparison.score
        values: dict[str, object] = {
            "model": found.model,
            "recordings": ", ".join(found.sources),
            "RMSE [N·m]": score.total,
            "nMSE": score.mean_nmse,
            **errors_of(score, "error"),
            "outside the identified range": f"{outside:.1%}",
            **{f"where {number}": text for number, text in enumerate(words[:REGIONS], 1)},
            **files,
        }
        worst = words[0] if words else "the error is spread evenly"
        level, message = Level.OK, f"{score.total:.4g} N·m; {worst}"
        if outside > OUT_OF_RANGE:
            level = Level.WARN
            message += (
                f"; {outside:.0%} of the motion lies outside what the model was identified on"
            )
        regions = (f"  {text}" for text in words[:REGIONS])
        status = Status(level, message, values)
        log = message, *regions, *base.lines_of(files)
        return Result(log, {self.title: status}, report=files.get("JSON", ""))
