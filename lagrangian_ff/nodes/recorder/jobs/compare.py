"""The service ~/compare: where the model fails on the last recording."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs import base
from lagrangian_ff.nodes.recorder.session import new_path
from lagrangian_ff.progress import Progress, part

SHOWN = ("model", "sources", "joints", "rmse", "nmse", "outside_range", "words")
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
            **given.common, model_file=str(given.present_model), bags=(str(last),),
            output=str(new_path(given.directory, f"{last.name}_{cls.service}", ".json")),
        )  # fmt: skip

    def summary(self) -> str:
        return f"started to compare {Path(self.model_file).name} with {base.names_of(self.bags)}"

    def work(self, progress: Progress) -> dict[str, Any]:
        """Write JSON and page, and return what the node shows of them."""
        from lagrangian_ff.diagnosis import compare
        from lagrangian_ff.diagnosis.where import locate
        from lagrangian_ff.recording import concatenate
        from lagrangian_ff.report import compare_page

        model = self.open_model()
        whole = concatenate(self.read_for(model, self.bags, part(progress, 0.0, 0.1)))
        comparison = compare(model, whole, progress=part(progress, 0.1, 0.5), intervals=True)
        where = locate(model, comparison, progress=part(progress, 0.5, 0.95))
        names = {"model": self.model_file, "sources": list(self.bags)}
        record, output = {**names, **where.record()}, Path(self.output)
        base.write_json(output, record)
        progress(0.95, "writing the page")
        page = base.write_page(compare_page, output, {**names, **where.record(series=True)})
        return {**{name: record[name] for name in SHOWN}, "json": str(output), **page}

    @classmethod
    def status(cls, record: Mapping[str, Any]) -> Status:
        words, outside = record["words"], record["outside_range"]
        values: dict[str, object] = {
            "model": record["model"],
            "recordings": ", ".join(record["sources"]),
            "RMSE [N·m]": record["rmse"],
            "nMSE": record["nmse"],
            **{
                f"error {joint}": f"{error['rmse']:.4g} N·m, nMSE {error['nmse']:.4g}"
                for joint, error in record["joints"].items()
            },
            "outside the identified range": f"{outside:.1%}",
            **{f"where {number}": text for number, text in enumerate(words[:REGIONS], 1)},
            **base.files_of(record),
        }
        worst = words[0] if words else "the error is spread evenly"
        message = f"{record['rmse']:.4g} N·m; {worst}"
        if outside <= OUT_OF_RANGE:
            return Status(Level.OK, message, values)
        message += f"; {outside:.0%} of the motion lies outside what the model was identified on"
        return Status(Level.WARN, message, values)

    def details(self, record: Mapping[str, Any]) -> list[str]:
        return [f"  {text}" for text in record["words"][:REGIONS]]
