"""A study as rows for CSV."""

from typing import Any

from seat_gear_dynamics.studies.taguchi.result import Setting, Study

Row = dict[str, Any]


def run_rows(study: Study) -> list[Row]:
    """Return one row for each experiment of the inner array: run, factors, noise, responses, failure."""
    return [
        {"run": number, **_labelled(study, {**run.setting, **outcome.noise}), **outcome.values, "failure": failure}
        for number, run in enumerate(study.runs, 1)
        for outcome in run.outcomes
        for failure in [outcome.failure or ""]
    ]


def ratio_rows(study: Study) -> list[Row]:
    """Return one row for each run of the inner array: factors, then ratio (dB) and mean of every response."""
    rows = []
    for number, run in enumerate(study.runs, 1):
        row: Row = {"run": number, **_labelled(study, run.setting)}
        for response in study.findings:
            row |= {f"{response} S/N (dB)": run.ratios.get(response), f"{response} mean": run.mean(response)}
        rows.append(row)
    return rows


def variance_rows(study: Study) -> list[Row]:
    """Return the analysis of variance of every response, one row for each source; shares between 0 and 1."""
    return [
        {"response": name, **source.as_dict()}
        for name, finding in study.findings.items()
        if finding.analysis is not None
        for source in (*finding.analysis.factors, finding.analysis.error, finding.analysis.total)
    ]


def effect_rows(study: Study) -> list[Row]:
    """Return the mean ratio (dB) of every level of every factor for each response, and which level is best."""
    rows = []
    for name, finding in study.findings.items():
        if finding.analysis is None:
            continue
        best = finding.analysis.best_levels
        for factor in study.factors:
            means = finding.analysis.effects[factor.name]
            rows += [
                {
                    "response": name,
                    "factor": factor.name,
                    "unit": factor.unit,
                    "level": index + 1,
                    "value": value,
                    "S/N (dB)": mean,
                    "best": index == best[factor.name],
                    "failed runs": sum(study.runs[n - 1].levels[factor.name] == index for n in study.diverged),
                }
                for index, (value, mean) in enumerate(zip(factor.levels, means, strict=True))
            ]
    return rows


def _labelled(study: Study, setting: Setting) -> Row:
    units = {factor.name: factor.unit for factor in (*study.factors, *study.noise)}
    return {f"{name} ({units[name]})": value for name, value in setting.items()}
