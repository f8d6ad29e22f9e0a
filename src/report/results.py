"""Reading results, in which any key may be missing, and sums over families of rays."""

import math


def at(item, *keys, missing=math.nan):
    """The value below these keys; `missing` where there is none."""
    for key in keys:
        item = item.get(key) if isinstance(item, dict) else None
        if item is None:
            return missing
    return item


def tracers_of(runs):
    """The tracers' specs, in the order of the runs."""
    return list(dict.fromkeys(run.get("spec", "") for run in runs))


def spread_of_quartiles(quartiles):
    """Half the distance between the quartiles."""
    if not at(quartiles, "median", missing=0):
        return ""
    return f"±{50 * (quartiles['high'] - quartiles['low']) / quartiles['median']:.0f}\u202f%"


def families_of(runs):
    return [family for run in runs for family in run.get("families", [])]


def verdicts_of(run, verdict, any_hit=False):
    """How often a run's closest hits, or any-hit queries, got this verdict."""
    if any_hit and "any" in run:
        return at(run, "any", "verdicts", verdict, missing=0)
    families = [f.get("any", {}) if any_hit else f for f in run.get("families", [])]
    return sum(at(f, "verdicts", verdict, missing=0) for f in families)


def rays_of(runs):
    return sum(f.get("rays", 0) for f in families_of(runs))


def case_verdicts(case, verdict):
    """The count of a verdict in an extreme case, closest and any hit together."""
    return at(case, "verdicts", verdict, missing=0) + at(case, "any", "verdicts", verdict, missing=0)


class Spread:
    """The distribution of an error, added up over families from their histograms: bins of 1/perOctave octaves."""

    def __init__(self, errors):
        self.zeros, self.bins, self.most = 0, {}, math.nan
        self.per_octave = 0
        for error in errors:
            self._add(error or {})
        self.total = self.zeros + sum(self.bins.values())

    def _add(self, error):
        largest = at(error, "max", "value")
        if not largest <= self.most:
            self.most = largest if not math.isnan(largest) else self.most
        histogram = error.get("histogram")
        if not histogram:
            return
        self.per_octave = histogram["perOctave"]
        self.zeros += histogram["zeros"]
        for place, n in enumerate(histogram["bins"]):
            key = histogram["first"] * self.per_octave + place
            self.bins[key] = self.bins.get(key, 0) + n

    def quantile(self, q):
        """The quantile q: 0 when it lies below all bins, NaN when nothing was counted."""
        if not self.total:
            return math.nan
        below = self.zeros
        if below >= q * self.total:
            return 0.0
        for key in sorted(self.bins):
            below += self.bins[key]
            if below >= q * self.total:
                # The end of a bin may lie beyond the largest value in it.
                return min(self.most, 2.0 ** ((key + 1) / self.per_octave))
        return self.most

    def octaves(self):
        """Counts by octave: finer bars would not be visible."""
        sums = {}
        for key, n in self.bins.items():
            if n:
                sums[key // self.per_octave] = sums.get(key // self.per_octave, 0) + n
        return sorted(sums.items())
