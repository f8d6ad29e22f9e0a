"""The page of `fathom validate`."""

import math

from figure import Plot, side_by_side
from html_page import Cell, Section, absent, code, count, details, exact, facts, group, machine_facts, num, number, page, paragraph, passed, table, text, whole, words
from results import Spread, at, case_verdicts, families_of, rays_of, tracers_of, verdicts_of

MEANINGS = {
    "agree": "the exact hit or miss, t to the last places",
    "tie": "another primitive at the same t",
    "edge": "closer to an edge than the tracer’s precision can tell",
    "range": "closer to an end of the interval than it can tell",
    "conditioned": "t off by at most a bound: a constant times the condition number of that intersection times the unit roundoff",
    "beyond": "numbers that leave the range of the tracer’s floats",
    "leak": "what the tracer is known to miss: surfaces at edges and vertices",
    "wrong": "anything else",
}
MARKS = {"wrong": "bad", "leak": "leak"}
ORDINARY = ("camera", "uniform")
FAILURES_SHOWN = 20
# Range of the maps' colours. The limit of the constant is 16 to 64, depending on the shape; below 0.1 a result is nearly exact.
CONSTANTS = (0.1, 100)


# ---- the head ----


def plural(n, noun):
    return f"{count(n)} {noun}{'' if n == 1 else 's'}"


def findings_of(runs):
    return [f"{r.get('spec', '')}, {r.get('scene', '')}: {words}" for r in runs for words in r.get("findings", [])]


def verdict(results):
    runs, cases, shading = results.get("runs", []), results.get("extremes", []), results.get("shading", [])
    wrong = sum(verdicts_of(r, "wrong", any_hit) for r in runs for any_hit in (False, True))
    wrong += sum(at(f, "others", "verdicts", "wrong", missing=0) for f in families_of(runs))
    leaks = sum(verdicts_of(r, "leak", any_hit) for r in runs for any_hit in (False, True)) + sum(case_verdicts(c, "leak") for c in cases)
    bad_cases, bad_shading = sum(not c.get("ok") for c in cases), sum(not c.get("ok") for c in shading)
    faults = []
    if wrong:
        faults.append(f"{plural(wrong, 'answer')} wrong")
    if findings_of(runs):
        faults.append(f"{plural(len(findings_of(runs)), 'statistic')} out of bounds")
    if bad_cases:
        faults.append(f"{count(bad_cases)} of {count(len(cases))} extreme cases failed")
    if bad_shading:
        faults.append(f"{count(bad_shading)} of {count(len(shading))} shading cases out of bounds")
    rays = rays_of(runs) + sum(c.get("rays", 0) for c in cases)
    said = (", ".join(faults) or "Nothing wrong") + f" in {count(rays)} rays"
    if leaks:
        said += f"; {plural(leaks, 'tracer leak')}"
    found = "".join(f"<li>{text(line)}</li>\n" for line in findings_of(runs))
    return f'<p class="verdict {"bad" if faults else "good"}">{said}.</p>\n' + (f"<ul>\n{found}</ul>\n" if found else "")


def head(results):
    runs = results.get("runs", [])
    scenes = dict.fromkeys(run.get("scene", "") for run in runs)
    pairs = [
        ("Scenes", ", ".join(map(text, scenes))),
        ("Tracers", ", ".join(f"<code>{text(s)}</code>" for s in tracers_of(runs))),
        *machine_facts(results),
        ("Rays", f"{count(results.get('raysPerFamily', 0))} of each family, scene and tracer; seed {count(results.get('seed', 0))}"),
        ("Exit code", "0 when nothing is wrong, 1 otherwise. Leaks are faults that a tracer is known for; they are counted and are not wrong."),
    ]
    return verdict(results) + facts(pairs)


# ---- runs ----


def verdict_names(runs):
    families = families_of(runs)
    return list(at(families[0], "verdicts", missing={})) if families else []


def constant_of(families):
    values = [at(f, "constant", "value", missing=None) for f in families]
    return max((v for v in values if v is not None), default=None)


def spread_cells(spread):
    return [num(spread.quantile(0.5)), num(spread.quantile(0.999)), num(spread.most)]


def error_columns(names):
    return ["#rays", *("#" + n for n in names), "#constant", "#median ulp", "#99.9\u202f% ulp", "#max ulp"]


def by_tracer(runs, rows_of):
    """Rows in groups, one for each tracer."""
    rows = []
    for spec in tracers_of(runs):
        own = [r for r in runs if r.get("spec", "") == spec]
        rows += [group(spec, own[0].get("tracer", "")), *rows_of(own)]
    return rows


def run_row(run, names):
    families = run.get("families", [])
    return [words(run.get("scene", "")), whole(rays_of([run])), *(whole(verdicts_of(run, n), MARKS.get(n, "")) for n in names),
            num(constant_of(families)), *spread_cells(Spread(f.get("tUlps") for f in families)), num(at(run, "nsPerRay"))]


def family_rows(runs, names):
    rows = []
    for name in dict.fromkeys(f.get("family", "") for f in families_of(runs)):
        own = [f for f in families_of(runs) if f.get("family", "") == name]
        sums = [sum(at(f, "verdicts", n, missing=0) for f in own) for n in names]
        rows.append([words(name), whole(sum(f.get("rays", 0) for f in own)), *(whole(s, MARKS.get(n, "")) for s, n in zip(sums, names)),
                     num(constant_of(own)), *spread_cells(Spread(f.get("tUlps") for f in own))])
    return rows


def any_rows(runs, names):
    return [[words(r.get("scene", "")), *(whole(verdicts_of(r, n, True), MARKS.get(n, "")) for n in names)] for r in runs]


def other_rows(runs):
    others = {"tRelative": "t, relative to the scene’s size", "position": "position, ulp", "normal": "normal, ulp", "uv": "u and v, ulp"}
    spreads = [(name, Spread(f.get(key) for f in families_of(runs))) for key, name in others.items()]
    return [[words(name), *spread_cells(s)] for name, s in spreads if s.total]


def explain(names):
    terms = [(n, MEANINGS[n]) for n in names if n in MEANINGS]
    terms += [
        ("constant", "the largest error of t over the condition number times the unit roundoff"),
        ("ulp", "the error of t in units in the last place of t as a float: the median, the value that all but 1 in 1000 rays do not exceed, the largest"),
        ("ns a ray", "nanoseconds of tracing alone, one thread, closest hit"),
    ]
    return details("What the verdicts and columns mean", facts(terms))


def runs_section(results):
    runs = results.get("runs", [])
    names = verdict_names(runs)
    if not names:
        return Section("tracers", "Tracers and scenes", absent("Left out: these results have no runs of families."))
    markup = table("Closest hits of each tracer in each scene, all families of rays", ["scene", *error_columns(names), "#ns a ray"],
                   by_tracer(runs, lambda own: [run_row(r, names) for r in own]))
    markup += explain(names)
    markup += details("By family of rays", table("Closest hits of each tracer by family of rays, all scenes", ["family", *error_columns(names)],
                                                 by_tracer(runs, lambda own: family_rows(own, names))))
    if any(verdicts_of(r, n, True) for r in runs for n in names):
        markup += details("Any-hit queries", table("Whether anything is met, as shadow rays ask", ["scene", *("#" + n for n in names)],
                                                   by_tracer(runs, lambda own: any_rows(own, names))))
    if other_rows(runs):
        markup += details("Errors of position, normal and uv", table("Errors over all scenes and families", ["error of", "#median", "#99.9\u202f%", "#max"],
                                                                     by_tracer(runs, other_rows)))
    return Section("tracers", "Tracers and scenes", markup)


def leaks_section(results):
    runs = results.get("runs", [])
    leaking = [n for n in dict.fromkeys(f.get("family", "") for f in families_of(runs))
               if any(at(f, "verdicts", "leak", missing=0) for f in families_of(runs) if f.get("family") == n)]
    if not leaking:
        return Section("leaks", "Tracer leaks", absent("None: no tracer missed what it is known to miss."))
    rows = []
    for spec in tracers_of(runs):
        own = [r for r in runs if r.get("spec", "") == spec]
        all_leaks = sum(verdicts_of(r, "leak") for r in own)
        if all_leaks:
            counts = [sum(at(f, "verdicts", "leak", missing=0) for f in families_of(own) if f.get("family") == n) for n in leaking]
            rows.append([code(spec), words(own[0].get("isa") or ""), *(whole(c, "leak") for c in counts), whole(all_leaks), num(100 * all_leaks / rays_of(own))])
    about = paragraph("Surfaces that a tracer missed at an edge or a vertex, where they continue on the other side. Which rays leak depends on the "
                      "instructions that the tracer was built for.")
    return Section("leaks", "Tracer leaks", about + table("Leaks by tracer and family of rays, all scenes",
                                                          ["tracer", "instructions", *("#" + n for n in leaking), "#all", "#% of rays"], rows))


def failures_section(results):
    lines = [line for run in results.get("runs", []) for line in run.get("failures", [])][:FAILURES_SHOWN]
    about = paragraph("The first ones. Save them to a file and <code>fathom validate --replay FILE</code> asks them again; "
                      "<code>--failures FILE</code> writes all of them.")
    return Section("failures", "Failing rays", about + "<pre>" + "".join(text(line) + "\n" for line in lines) + "</pre>\n") if lines else None


# ---- plots ----


def time_of(runs):
    """Nanoseconds a ray over all scenes, weighted by rays; NaN where a run has no time."""
    rays = rays_of(runs)
    return sum(at(r, "nsPerRay") * rays_of([r]) for r in runs) / rays if rays else float("nan")


def error_plot(runs, title, wanted):
    plot = Plot(title, "nanoseconds a ray", "error of t, ulp of a float", size=(1040, 440),
                summary="Each tracer’s error of t in ulp against its nanoseconds a ray. The table of tracers and scenes has the numbers.")
    for series, spec in enumerate(tracers_of(runs)):
        own = [r for r in runs if r.get("spec", "") == spec]
        spread = Spread(f.get("tUlps") for f in families_of(own) if wanted(f.get("family", "")))
        x, y = time_of(own), spread.quantile(0.999)
        said = f"{spec}: {number(x)} ns a ray; error of t {number(y)} ulp for all but 1 in 1000 rays, at most {number(spread.most)} ulp"
        plot.point(x, y, said, series=series, high=spread.most, label=spec)
    return plot.markup()


def time_section(results):
    runs = results.get("runs", [])
    timed = runs and all("nsPerRay" in r for r in runs) and any("histogram" in f.get("tUlps", {}) for f in families_of(runs))
    if not timed:
        return Section("time", "Error against time", absent("Left out: these results have no times of the tracers."))
    about = paragraph("The cost of an answer against its error. Both axes are logarithmic; lower and further left is better. A filled mark is the error "
                      "of all but 1 in 1000 rays, a hollow one the largest. Difficult rays are mostly ill-conditioned: there even the nearest float is "
                      "many units off, for any tracer.")
    return Section("time", "Error against time", about + side_by_side([
        error_plot(runs, "Ordinary rays: camera and uniform", lambda f: f in ORDINARY),
        error_plot(runs, "Difficult rays: all other families", lambda f: f not in ORDINARY),
    ]))


def histogram(spec, spread, limits):
    caption = (f"{count(spread.total)} rays; median {number(spread.quantile(0.5))} ulp, 99.9\u202f% {number(spread.quantile(0.999))} ulp, largest "
               f"{number(spread.most)} ulp; {count(spread.zeros)} without error.")
    plot = Plot(spec, "error of t, ulp of a float", "rays", summary=caption, size=(340, 240))
    plot.bars([(2.0**o, 2.0 ** (o + 1), n, f"{number(2.0 ** o)} to {number(2.0 ** (o + 1))} ulp: {plural(n, 'ray')}") for o, n in spread.octaves()])
    plot.axes.set_xlim(*limits[:2])
    plot.axes.set_ylim(0.7, limits[2])
    return plot.markup(caption)


def histograms_section(results):
    runs = results.get("runs", [])
    spreads = {s: Spread(f.get("tUlps") for f in families_of([r for r in runs if r.get("spec", "") == s])) for s in tracers_of(runs)}
    octaves = [o for s in spreads.values() for o, _ in s.octaves()]
    if not octaves:
        return Section("histograms", "Distribution of errors", absent("Left out: these results have no histograms."))
    most = max(n for s in spreads.values() for _, n in s.octaves())
    limits = (2.0 ** min(octaves), 2.0 ** (max(octaves) + 1), 2 * most)
    about = paragraph("How many rays have which error of t, over all scenes and families. One bar doubles the error; heights are logarithmic, so that the "
                      "few rays far out are seen.")
    return Section("histograms", "Distribution of errors", about + side_by_side([histogram(spec, s, limits) for spec, s in spreads.items()]))


# ---- extreme cases ----


def heat(value):
    """Position in the range of colours, from 0 to 1, on a logarithmic scale."""
    low, high = (math.log(v) for v in CONSTANTS)
    return 0.0 if not value or value <= 0 else min(1.0, max(0.0, (math.log(value) - low) / (high - low)))


def worst_case(cases):
    return max(cases, key=lambda c: (not c.get("ok") or case_verdicts(c, "wrong") > 0, case_verdicts(c, "leak") > 0, at(c, "constant", missing=0)))


def map_cell(cases):
    if not cases:
        return Cell("")
    case = worst_case(cases)
    wrong, leaks = case_verdicts(case, "wrong"), case_verdicts(case, "leak")
    constant = at(case, "constant", missing=None)
    said = (f"{case.get('spec')}, {case.get('case')}: constant {number(constant)}; {plural(case.get('rays', 0), 'ray')}, {count(leaks)} leak, "
            f"{count(wrong)} wrong{'' if case.get('ok') else '; FAILED'}")
    bad = wrong or not case.get("ok")
    sign = " ✗" if bad else " ◦" if leaks else ""
    shown = f"{constant:.2g}" if constant is not None else "–"
    cell = Cell(f'<span title="{text(said)}">{text(shown)}{sign}</span>', "wrong" if bad else "")
    cell.heat = heat(constant)
    return cell


def case_map(name, cases):
    """Rows are tracers, columns values of the parameter; a shade for each magnitude."""
    parameters = sorted({at(c, "parameter", missing=0) or 0 for c in cases})
    named = {p: next(c.get("case", "") for c in cases if (at(c, "parameter", missing=0) or 0) == p) for p in parameters}
    heads = "".join(f'<th scope="col" class="n" title="{text(named[p])}">{number(p)}</th>' for p in parameters)
    rows = ""
    for spec in tracers_of(cases):
        cells = ""
        for p in parameters:
            cell = map_cell([c for c in cases if c.get("spec") == spec and (at(c, "parameter", missing=0) or 0) == p])
            kind = f' class="{cell.kind}"' if cell.kind else ""
            cells += f'<td{kind} style="--heat-of:{getattr(cell, "heat", 0) * 0.75:.2f}">{cell.markup}</td>'
        rows += f'<tr><th scope="row"><code>{text(spec)}</code></th>{cells}</tr>\n'
    first, last = named[parameters[0]], named[parameters[-1]]
    caption = text(first) if first == last else f"{text(first)} … {text(last)}"
    return (f'<figure class="map"><h3>{text(name)}</h3>\n<div class="scroll"><table>\n<thead><tr><th></th>{heads}</tr></thead>\n<tbody>\n{rows}</tbody></table>'
            f"</div>\n<figcaption>{caption}</figcaption></figure>\n")


def groups_of(cases):
    names = dict.fromkeys(c.get("group", "") for c in cases)
    return {name: [c for c in cases if c.get("group", "") == name] for name in names}


def case_row(case):
    return [words(case.get("case", "")), code(case.get("spec", "")), whole(case.get("rays", 0)), whole(case_verdicts(case, "leak"), "leak"),
            whole(case_verdicts(case, "wrong"), "bad"), num(at(case, "constant")), passed(case.get("ok"))]


def extremes_section(results):
    cases = results.get("extremes", [])
    if not cases:
        return Section("extremes", "Extreme cases", absent("Left out: these results have none; --extremes runs them."))
    about = paragraph("One map for each kind of case: rows are tracers, columns values of the parameter. The number, and the shade, is the largest error of t in "
                      "units of the condition number times the unit roundoff, which the verdicts bound. ◦ marks leaks, ✗ a failure.")
    rows = []
    for name, own in groups_of(cases).items():
        rows += [group("", name), *(case_row(c) for c in own)]
    everything = details("All cases with their numbers", table("Every extreme case", ["case", "tracer", "#rays", "#leak", "#wrong", "#constant", ""], rows))
    return Section("extremes", "Extreme cases", about + side_by_side(case_map(n, own) for n, own in groups_of(cases).items()) + everything)


# ---- shading ----


def ratio_of(case):
    error, bound = at(case, "error", missing=0), at(case, "bound", missing=0)
    return 0.0 if error <= 0 else error / bound if bound > 0 else float("inf")


def ratio_bar(ratio):
    """The error over its bound, from a millionth to ten; the upright line is the bound."""
    width = 0.0 if ratio <= 1e-6 else min(1.0, (math.log10(ratio) + 6) / 7) if ratio < float("inf") else 1.0
    kind = "over" if ratio > 1 else "fine"
    return Cell(f'<span class="ratio" title="{number(ratio)} of the bound"><span class="{kind}" style="width:{100 * width:.1f}%"></span><i></i></span>')


def shading_section(results):
    cases = results.get("shading", [])
    if not cases:
        return Section("shading", "Shading at extremes", absent("Left out: these results have none; --extremes runs them."))
    rows, every = [], []
    for name, own in groups_of(cases).items():
        worst = max(own, key=ratio_of)
        rows.append([words(name), whole(len(own)), whole(sum(not c.get("ok") for c in own), "bad"), num(ratio_of(worst)), ratio_bar(ratio_of(worst)),
                     Cell(text(worst.get("case", "")), "wide")])
        every.append(group("", name))
        every += [[words(c.get("case", "")), exact(at(c, "measured")), exact(at(c, "expected")), num(at(c, "error")), num(at(c, "bound")),
                   ratio_bar(ratio_of(c)), passed(c.get("ok"))] for c in own]
    failed = "".join(f"<li>{text(c.get('group', ''))}: {text(c.get('case', ''))}; error {number(at(c, 'error'))}, bound {number(at(c, 'bound'))}</li>\n"
                     for c in cases if not c.get("ok"))
    about = paragraph("Rendered values against closed forms. A bar is the error over its bound on a logarithmic scale from a millionth to ten; the upright "
                      "line is the bound.")
    markup = about + table("Groups of shading cases, and the case of each that comes nearest to its bound",
                           ["", "#cases", "#failed", "#largest error / bound", "", "in"], rows)
    markup += f"<p>Out of bounds:</p>\n<ul>\n{failed}</ul>\n" if failed else ""
    markup += details("All cases with their numbers", table("Every shading case", ["case", "#measured", "#expected", "#error", "#bound", "error / bound", ""], every))
    return Section("shading", "Shading at extremes", markup)


def page_of(results):
    parts = (runs_section, leaks_section, failures_section, time_section, histograms_section, extremes_section, shading_section)
    sections = [section for section in (part(results) for part in parts) if section]
    return page("Fathom: tracers against exact arithmetic", head(results), sections)
