"""The pages of `fathom bench`: one function for each kind of results."""

from figure import Plot, side_by_side
from html_page import Section, absent, code, count, facts, group, machine_facts, num, number, page, paragraph, table, whole, words
from results import at, spread_of_quartiles, tracers_of

SETS = {
    "camera": "Camera rays: closest hit, coherent",
    "bounce": "Bounced rays: closest hit, incoherent",
    "shadow": "Shadow rays: any hit, coherent",
    "between": "Rays between points: any hit, incoherent",
}
CLOCKS = {"cpu": "processor", "wall": "clock"}
METRICS = {
    "rmse": ("RMSE", "RMSE of linear values"),
    "relmse": ("relative MSE", "relative MSE"),
    "flip": ("FLIP", "FLIP, 0 to 1"),
}
# A fitted slope with a larger half interval is drawn without it, because the interval would fill the plot.
HALF_DRAWN = 0.5


def listing(caption, columns, items):
    """A table with a row for each item. columns: a path such as "seconds.median", or a function that makes the cell, by its heading."""

    def cell(item, heading, column):
        if callable(column):
            return column(item)
        value = at(item, *column.split("."))
        if isinstance(value, str):
            return words(value)
        if not heading.startswith("#"):
            return words(number(value) if isinstance(value, float) else count(value))
        return whole(value) if isinstance(value, int) else num(value)

    return table(caption, list(columns), [[cell(item, heading, column) for heading, column in columns.items()] for item in items])


# ---- trace ----


def sets_of(runs):
    """The names of all sets of rays, in the order of the runs."""
    return list(dict.fromkeys(rate.get("set") for run in runs for rate in run.get("rates", [])))


def rate_of(run, name):
    return next((r for r in run.get("rates", []) if r.get("set") == name), {})


def trace_row(run, sets):
    row = [code(run.get("spec", "")), num(at(run, "buildSeconds")), num(1e-6 * at(run, "bvhBytes"))]
    for name in sets:
        rate = rate_of(run, name)
        row += [num(at(rate, "millionRaysPerCpuSecond", "median")), words(spread_of_quartiles(rate.get("millionRaysPerCpuSecond", {}))),
                whole(rate.get("rays", 0))]
    return row


def trace_table(runs):
    sets = sets_of(runs)
    columns = ["tracer", "#build, s", "#BVH, MB"]
    for name in sets:
        columns += ["#" + name, "spread", "#rays"]
    rows, last = [], None
    for run in runs:
        scene = (run.get("scene"), run.get("triangles"))
        if scene != last:
            rows.append(group(scene[0] or "", f"{count(scene[1] or 0)} triangles"))
        last = scene
        rows.append(trace_row(run, sets))
    return table("Million rays a second of processor time, seconds to build, megabytes of BVH", columns, rows)


def fewer_rays(runs, run, name):
    """True if the tracer traced fewer rays than others in the same scene, because it is slow."""
    most = max(rate_of(r, name).get("rays", 0) for r in runs if r.get("triangles") == run.get("triangles"))
    return rate_of(run, name).get("rays", 0) < most


def trace_plot(runs, title, unit, value, is_slow):
    plot = Plot(title, "triangles", unit, summary="Each tracer over the number of triangles. The table has the numbers.", size=(1040, 430))
    for series, spec in enumerate(tracers_of(runs)):
        own = sorted((r for r in runs if r["spec"] == spec), key=lambda r: at(r, "triangles"))
        plot.line([at(r, "triangles") for r in own], [value(r) for r in own], series=series)
        for place, r in enumerate(own):
            title = f"{spec}, {count(r['triangles'])} triangles: {number(value(r))} {unit}"
            plot.point(at(r, "triangles"), value(r), title, series=series, hollow=is_slow(r), label=None if place else spec)
    return plot.markup()


def trace_growth(runs):
    if len({r.get("triangles") for r in runs}) < 2:
        return absent("One scene only: --triangles 10k,100k,1M shows how rates fall with the triangles.")
    plots = [
        trace_plot(runs, SETS.get(name, name), "million rays a second", lambda r, n=name: at(rate_of(r, n), "millionRaysPerCpuSecond", "median"),
                   lambda r, n=name: fewer_rays(runs, r, n))
        for name in sets_of(runs)
    ]
    plots.append(trace_plot(runs, "Building", "seconds", lambda r: at(r, "buildSeconds"), lambda r: False))
    plots.append(trace_plot(runs, "BVH", "megabytes", lambda r: 1e-6 * at(r, "bvhBytes"), lambda r: False))
    return paragraph("Medians; a hollow mark is a median of fewer rays, of a slow tracer.") + side_by_side(plots)


def trace(results):
    runs = results.get("runs", [])
    about = paragraph(
        "Rays for each second of a thread’s processor time: medians, half the distance of the quartiles, and how many rays each "
        "repetition had. Slow tracers get fewer rays, taken evenly from the same set. Tracers took turns."
    )
    return [Section("rates", "Million rays a second", about + trace_table(runs)), Section("growth", "By triangle count", trace_growth(runs))]


# ---- render ----


SOURCE = {"scene": "scene", "#triangles": "triangles", "tracer": "spec", "samples a pixel": "spp"}


def render_ceiling(runs):
    columns = {**SOURCE, "#bare calls, s": "ceiling.bareCpuSeconds.median", "#render over bare": "ceiling.renderToBare.median",
               "#lower quartile": "ceiling.renderToBare.low", "#upper quartile": "ceiling.renderToBare.high",
               "#tracer over bare": "ceiling.tracedToBare.median", "#closest-hit rays": "ceiling.closestRays", "#any-hit rays": "ceiling.anyRays"}
    return listing("Processor time of the render phase over that of the bare calls", columns, [r for r in runs if r.get("ceiling")])


def render_speeds(runs):
    columns = {**SOURCE, "#threads": "threads", "#seconds": "seconds.median", "#lower quartile": "seconds.low",
               "#upper quartile": "seconds.high", "#processor seconds": "cpuSeconds.median", "#million rays a second": "millionRaysPerSecond",
               "#speedup": "speedup.median"}
    speeds = [{**{key: run.get(key) for key in SOURCE.values()}, **speed} for run in runs for speed in run.get("speeds", [])]
    return listing("Seconds by the clock, medians and quartiles", columns, speeds)


def render_phases(runs):
    columns = {**SOURCE, **{"#" + phase: f"seconds.{phase}" for phase in ("read", "build", "plan", "render", "write")},
               "#build, processor": "buildSeconds.cpu.median", "#BVH, bytes": "bvhBytes", "#while built, bytes": "bvhPeakBytes",
               "#camera rays": "rays.camera", "#shadow rays": "rays.shadow", "#reflected": "rays.reflection", "#refracted": "rays.refraction"}
    return listing("Seconds of each phase by the clock, and rays by kind", columns, runs)


def render_growth(results):
    """Phases over the number of triangles, a series for each tracer and number of samples that a law was fitted to."""
    runs, fits = results.get("runs", []), results.get("fits", [])
    if not fits:
        return absent("One size only: --triangles 10k,100k,1M shows how the phases grow with the triangles.")
    phases = {"read": ("Reading", "readSeconds.cpu.median"), "build": ("Building", "buildSeconds.cpu.median"),
              "render": ("The render phase, by one thread", "ceiling.renderCpuSeconds.median"), "bare": ("Embree’s bare calls", "ceiling.bareCpuSeconds.median"),
              "renderToBare": ("The render phase over the bare calls", "ceiling.renderToBare.median")}
    plots = []
    for name, (title, path) in phases.items():
        unit = "times" if name == "renderToBare" else "processor seconds"
        plot = Plot(title, "triangles", unit, summary="Over the number of triangles. The table has the numbers.", size=(520, 400))
        for series, fit in enumerate(f for f in fits if f["of"] == name):
            own = [r for r in runs if (r["spec"], r["spp"]) == (fit["spec"], fit["spp"])]
            said = f"{fit['spec']}, {count(fit['spp'])} samples a pixel"
            for place, r in enumerate(own):
                x, y = at(r, "triangles"), at(r, *path.split("."))
                plot.point(x, y, f"{said}, {count(x)} triangles: {number(y)} {unit}", series=series, label=None if place else said)
            ends = [min(at(r, "triangles") for r in own), max(at(r, "triangles") for r in own)]
            plot.line(ends, [fit["scale"] * x ** fit["exponent"] for x in ends], series=series, dashed=True)
        plots.append(plot.markup())
    about = paragraph("Processor time, medians. Dashed: b of seconds ∝ triangles<sup>b</sup> by least squares of the logarithms, with half its 95\u202f% "
                      "interval in the table. 1 is linear. If that of render over bare is 0, both grow alike.")
    columns = {"": lambda fit: words(phases[fit["of"]][0]), "tracer": "spec", "samples a pixel": "spp", "#exponent": "exponent", "#±": "half",
               "#sizes": "sizes"}
    return about + side_by_side(plots) + listing("Fitted exponents", columns, fits)


def render(results):
    runs = results.get("runs", [])
    about = paragraph(
        "Embree’s calls alone over the rays of the same render, by one thread. The render phase makes, traces and shades rays and fills "
        "the film. Each ratio is a median over repetitions that took turns."
    )
    return [
        Section("ceiling", "Against the bare calls", about + render_ceiling(runs)),
        Section("threads", "The render phase by threads", render_speeds(runs)),
        Section("phases", "Phases and rays", render_phases(runs)),
        Section("growth", "By the number of triangles", render_growth(results)),
    ]


# ---- error ----


def error_points(results, metric):
    name, axis = METRICS[metric]
    plot = Plot(name, "processor seconds of rendering", axis, size=(520, 400),
                summary="Error of each pattern against seconds of processor time, with fitted lines. The tables have the numbers.")
    for series, curve in enumerate(results.get("curves", [])):
        fitted = []
        for place, p in enumerate(curve.get("points", [])):
            below = metric in p.get("belowReference", [])
            title = f"{curve['pattern']}, {count(p['spp'])} samples a pixel: {number(at(p, 'cpuSeconds'))} s, {name} {number(at(p, metric))}"
            title += "; too close to the reference" if below else ""
            plot.point(at(p, "cpuSeconds"), at(p, metric), title, series=series, hollow=below, label=None if place else curve["pattern"])
            if not below and at(p, metric) > 0:
                fitted.append(at(p, "cpuSeconds"))
        if len(fitted) > 1:
            draw_fit(plot, curve["slopes"][metric]["cpu"], fitted, series)
    return plot.markup()


def draw_fit(plot, fit, xs, series):
    """A power law through the middle of its points; also with both ends of the slope's interval."""
    slope, scale, half = at(fit, "slope"), at(fit, "scale"), at(fit, "half")
    ends = (min(xs), max(xs))
    middle = 1.0
    for x in xs:
        middle *= x ** (1 / len(xs))
    there = scale * middle**slope
    for side in (0, -1, 1):
        if side and not half <= HALF_DRAWN:
            continue
        plot.line(ends, [there * (x / middle) ** (slope + side * half) for x in ends], series=series, dashed=side != 0)


def error_plots(results):
    about = (
        f"Images of {count(results.get('width', 0))} × {count(results.get('height', 0))} pixels, {count(results.get('seeds', 0))} of each "
        f"pattern and number of samples. Times are of rendering alone; building took {number(at(results, 'build', 'cpuSeconds'))} s of "
        "processor time."
    )
    more = (
        "Both axes are logarithmic; lower and further left is better. A line is a power law by least squares. The dashed lines have the "
        "ends of its slope’s 95\u202f% interval over the seeds, where that is at most 0.5 to each side. With classic and a pinhole, the "
        "grid has no seed: its interval is of times alone. A hollow mark is too close to the reference and is in no fit."
    )
    return paragraph(about) + paragraph(more) + side_by_side([error_points(results, m) for m in METRICS])


def error_reference(results):
    reference = results.get("reference", {})
    about = (
        f"The mean of two independent halves of the pattern sobol with {count(reference.get('sppOfEach', 0))} samples a pixel each. Its own "
        "RMSE is half of the difference between them, its relative MSE a quarter. For FLIP the difference between them is a bound. An image "
        "closer to the reference than the halves are to each other is marked."
    )
    rows = [[words(name), *(num(at(reference, key, m)) for m in METRICS)]
            for name, key in (("its own", "ownError"), ("between its halves", "betweenHalves"))]
    return paragraph(about) + table("Errors of the reference", ["", *("#" + METRICS[m][0] for m in METRICS)], rows)


def error_slopes(results):
    about = paragraph("b in error ∝ seconds<sup>b</sup>, by least squares of the logarithms for each seed; the mean over the seeds and half its "
                      "95\u202f% interval by Student’s t.")
    columns = ["pattern", "time"]
    for m in METRICS:
        columns += ["#" + METRICS[m][0], "#±"]
    rows = []
    for curve in results.get("curves", []):
        for clock, name in CLOCKS.items():
            row = [words(curve["pattern"]), words(name)]
            for m in METRICS:
                row += [num(at(curve, "slopes", m, clock, "slope")), num(at(curve, "slopes", m, clock, "half"))]
            rows.append(row)
    return about + table("Slopes of ln error over ln seconds, and half the width of the 95\u202f% interval", columns, rows)


def error_equal(results, key, column, caption, first):
    patterns = [c["pattern"] for c in results.get("curves", [])]
    markup = ""
    for m in METRICS:
        rows = [[words(number(at(row, column))), *(num(at(row, p)) for p in patterns)] for row in at(results, key, m, missing=[])]
        name = METRICS[m][0]
        heads = [first or name, *("#" + p for p in patterns)]
        markup += table(caption.format(name), heads, rows) if rows else absent(f"{name}: the patterns have nothing in common here.")
    return markup


def error_images(results):
    names = ["#samples a pixel", "#processor s", "#clock s", *("#" + METRICS[m][0] for m in METRICS), "#not finite"]
    rows = []
    for curve in results.get("curves", []):
        for p in curve.get("points", []):
            broken = sum(r.get("notFinite", 0) for r in results.get("runs", []) if (r["pattern"], r["spp"]) == (curve["pattern"], p["spp"]))
            rows.append([words(curve["pattern"]), num(p["spp"]), num(at(p, "cpuSeconds")), num(at(p, "seconds")), *(num(at(p, m)) for m in METRICS),
                         whole(broken, "bad"), words(", ".join(METRICS[m][0] for m in p.get("belowReference", [])))])
    return table("Medians of times, geometric means of errors; rendering alone, without reading and building",
                 ["pattern", *names, "too close to the reference"], rows)


def error(results):
    return [
        Section("plots", "Error against time", error_plots(results)),
        Section("reference", "The reference", error_reference(results)),
        Section("slopes", "Slopes", error_slopes(results)),
        Section("time", "Equal time", error_equal(results, "equalTime", "cpuSeconds", "{} in the same time", "processor s")),
        Section("error", "Equal error", error_equal(results, "equalError", "error", "Processor seconds for the same {}", None)),
        Section("images", "All images", error_images(results)),
    ]


# ---- all ----

BENCHES = {
    "trace": ("Fathom: rays a second of every tracer", trace),
    "render": ("Fathom: the render phase against Embree’s bare calls", render),
    "error": ("Fathom: image error against run time", error),
}


def page_of(results):
    title, sections = BENCHES[results["bench"]]
    return page(title, facts(machine_facts(results)), sections(results))
