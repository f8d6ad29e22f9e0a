"""The pages of `fathom bench`: one function for each kind of results."""

from figure import Plot, side_by_side
from html_page import Section, absent, code, count, facts, group, num, number, page, paragraph, table, text, whole, words
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
# A fitted slope known no better than this is drawn without its interval, which would fill the plot.
HALF_DRAWN = 0.5


def head(results):
    machine = results.get("machine", {})
    named = [("Fathom", "fathom"), ("Commit", "commit"), ("Date", "date")]
    of_machine = [("Processor", "cpu"), ("Processors", "processors"), ("Load at the start", "load"), ("Embree", "embree"),
                  ("Instruction set", "isa"), ("Compiler", "compiler"), ("Flags", "flags")]
    pairs = [(name, text(results.get(key) or "")) for name, key in named]
    for name, key in of_machine:
        value = machine.get(key)
        pairs.append((name, number(value) if isinstance(value, (int, float)) else text(value or "")))
    return facts(pairs)


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


def rate_of(run, name):
    return next((r for r in run.get("rates", []) if r.get("set") == name), {})


def trace_row(run):
    row = [code(run.get("spec", "")), num(at(run, "buildSeconds")), num(1e-6 * at(run, "bvhBytes"))]
    for name in SETS:
        rate = rate_of(run, name)
        row += [num(at(rate, "millionRaysPerCpuSecond", "median")), words(spread_of_quartiles(rate.get("millionRaysPerCpuSecond", {}))),
                whole(rate.get("rays", 0))]
    return row


def trace_table(runs):
    columns = ["tracer", "#build, s", "#BVH, MB"]
    for name in SETS:
        columns += ["#" + name, "spread", "#rays"]
    rows, last = [], None
    for run in runs:
        scene = (run.get("scene"), run.get("triangles"))
        if scene != last:
            rows.append(group(scene[0] or "", f"{count(scene[1] or 0)} triangles"))
        last = scene
        rows.append(trace_row(run))
    return table("Million rays a second of processor time, seconds to build, megabytes of BVH", columns, rows)


def fewer_rays(runs, run, name):
    """Slow tracers are asked fewer rays than others of the same scene."""
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
        trace_plot(runs, title, "million rays a second", lambda r, n=name: at(rate_of(r, n), "millionRaysPerCpuSecond", "median"),
                   lambda r, n=name: fewer_rays(runs, r, n))
        for name, title in SETS.items()
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


def render_ceiling(runs):
    columns = {"samples a pixel": "spp", "#bare calls, s": "ceiling.bareCpuSeconds.median", "#render over bare": "ceiling.renderToBare.median",
               "#lower quartile": "ceiling.renderToBare.low", "#upper quartile": "ceiling.renderToBare.high",
               "#tracer over bare": "ceiling.tracedToBare.median", "#closest-hit rays": "ceiling.closestRays", "#any-hit rays": "ceiling.anyRays"}
    return listing("Processor time of the render phase over that of the bare calls", columns, [r for r in runs if r.get("ceiling")])


def render_speeds(runs):
    columns = {"samples a pixel": "spp", "#threads": "threads", "#seconds": "seconds.median", "#lower quartile": "seconds.low",
               "#upper quartile": "seconds.high", "#processor seconds": "cpuSeconds.median", "#million rays a second": "millionRaysPerSecond",
               "#speedup": "speedup.median", "#speedup of bare calls": "bareSpeedup.median"}
    speeds = [{"spp": run.get("spp"), **speed} for run in runs for speed in run.get("speeds", [])]
    return listing("Seconds by the clock, medians and quartiles", columns, speeds)


def render_phases(runs):
    columns = {"samples a pixel": "spp", **{"#" + phase: f"seconds.{phase}" for phase in ("read", "build", "plan", "render", "write")},
               "#camera rays": "rays.camera", "#shadow rays": "rays.shadow", "#reflected": "rays.reflection", "#refracted": "rays.refraction"}
    return listing("Seconds of each phase, and rays by kind", columns, runs)


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
    """A power law through the middle of its points, and those with the ends of the slope's interval."""
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
        "ends of its slope’s 95\u202f% interval over the seeds, where that is at most 0.5 to each side. The grid has no seed: its interval "
        "is of times alone. A hollow mark is too close to the reference and is in no fit."
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


# ---- growth ----


def growth_plot(results, title, unit, series, y_log=True):
    """series: name, the keys of a number of each run, the fit that is drawn or None, and a factor to the plot's unit."""
    plot = Plot(title, "triangles", unit, y_log=y_log, summary="Over the number of triangles. The table has the numbers.")
    runs = results.get("runs", [])
    xs = [at(r, "triangles") for r in runs]
    for k, (name, keys, fit, factor) in enumerate(series):
        ys = [factor * at(r, *keys) for r in runs]
        for place, (x, y) in enumerate(zip(xs, ys)):
            plot.point(x, y, f"{name}, {count(x)} triangles: {number(y)} {unit}", series=k, label=None if place else name)
        law = at(results, "fits", fit, "all", missing=None) if fit else None
        if law and xs:
            plot.line([xs[0], xs[-1]], [factor * at(law, "scale") * x ** at(law, "exponent") for x in (xs[0], xs[-1])], series=k, dashed=True)
        else:
            plot.line(xs, ys, series=k)
    if not y_log:
        plot.axes.set_ylim(bottom=0)
    return plot.markup()


def growth_plots(results):
    return paragraph("Processor time, medians. Dashed: a power law by least squares over all sizes.") + side_by_side([
        growth_plot(results, "Reading and building", "processor milliseconds",
                    [("reading", ("readSeconds", "cpu", "median"), "read", 1e3), ("building", ("buildSeconds", "cpu", "median"), "build", 1e3)]),
        growth_plot(results, "One sample a pixel, by one thread", "processor milliseconds",
                    [("render phase", ("renderCpuSeconds", "median"), None, 1e3), ("Embree’s bare calls", ("bareCpuSeconds", "median"), None, 1e3)]),
        growth_plot(results, "The render phase over the bare calls", "times", [("render over bare", ("renderToBare", "median"), None, 1)], y_log=False),
    ])


def growth_fits(results):
    names = {"read": "reading", "build": "building", "render": "render phase", "bare": "bare calls", "renderToBare": "render over bare"}
    about = paragraph("b of processor seconds ∝ triangles<sup>b</sup> with half its 95\u202f% interval: 1 is linear. If that of render over bare is 0, "
                      "both grow alike.")
    columns = {"": "name", "#all sizes": "all.exponent", "#±": "all.half", "#from a million on": "heavy.exponent", "#± of these": "heavy.half"}
    return about + listing("Fitted exponents", columns, [{"name": name, **at(results, "fits", key, missing={})} for key, name in names.items()])


def growth_sizes(results):
    columns = {"triangles": "triangles", "#file, bytes": "fileBytes", "#BVH, bytes": "bvhBytes", "#at most, bytes": "bvhPeakBytes",
               "#read, s": "readSeconds.cpu.median", "#read, clock s": "readSeconds.wall.median", "#build, s": "buildSeconds.cpu.median",
               "#build, clock s": "buildSeconds.wall.median", "#rays": "rays", "#render, s": "renderCpuSeconds.median",
               "#bare calls, s": "bareCpuSeconds.median", "#Mrays/s": "millionRaysPerCpuSecond.render",
               "#bare, Mrays/s": "millionRaysPerCpuSecond.bare", "#render over bare": "renderToBare.median"}
    about = paragraph("Seconds of processor time of all threads together; rendering uses one thread. At most: what Embree holds while it builds.")
    return about + listing("Reading, building and rendering by the number of triangles", columns, results.get("runs", []))


def growth(results):
    return [
        Section("plots", "By the number of triangles", growth_plots(results)),
        Section("exponents", "Exponents", growth_fits(results)),
        Section("sizes", "Sizes", growth_sizes(results)),
    ]


# ---- build ----


def best_range(quality, clock):
    range_ = at(quality, "bestFromToSpp", clock, missing=None)
    if not range_:
        return words("never")
    return words(f"{number(range_[0])} to {number(range_[1])}" if range_[1] is not None else f"{number(range_[0])} and more")


def build_qualities(results):
    about = paragraph(f"Medians over repetitions that took turns. A sample is one a pixel, over {count(results.get('width', 0))} × "
                      f"{count(results.get('height', 0))} pixels. The fastest is by build and render together.")
    columns = {"quality": "quality", "#build, processor s": "buildSeconds.cpu.median", "#build, clock s": "buildSeconds.wall.median",
               "#a sample, processor s": "sampleSeconds.cpu.median", "#a sample, clock s": "sampleSeconds.wall.median",
               "#Mrays/s": "millionRaysPerSecond", "#BVH, bytes": "bvhBytes", "#while built, bytes": "bvhPeakBytes",
               "fastest at spp, processor": lambda q: best_range(q, "cpu"), "fastest at spp, clock": lambda q: best_range(q, "wall")}
    return about + listing("Build quality against time", columns, results.get("qualities", []))


def build_totals(results, clock):
    columns = {"samples a pixel": "spp", **{"#" + q: f"{clock}.seconds.{q}" for q in ("low", "medium", "high")}, "best": f"{clock}.best",
               "automatic": "automatic", "#behind the best, %": lambda total: num(100 * at(total, clock, "automaticBehind"))}
    return listing(f"Build and render, {CLOCKS[clock]} seconds", columns, results.get("totals", []))


def build(results):
    return [
        Section("qualities", "What each quality costs and saves", build_qualities(results)),
        Section("totals", "By samples a pixel", "".join(build_totals(results, c) for c in CLOCKS)),
    ]


# ---- secondary ----


def secondary_plot(rows):
    plot = Plot("The render’s calls over single rays", "depth", "time over single rays", x_log=False, y_log=False, size=(620, 360),
                summary="Ratio of times by depth; 1 where both are as fast.")
    kinds = ["camera", "mirrored", "refracted", "shadow"]
    seen = set()
    for row in rows:
        kind = row.get("kind")
        title = f"{kind}, depth {row.get('depth')}: {number(at(row, 'renderToSingle', 'median'))}"
        plot.point(at(row, "depth"), at(row, "renderToSingle", "median"), title, series=kinds.index(kind), high=at(row, "renderToSingle", "high"),
                   label=None if kind in seen else kind)
        seen.add(kind)
    plot.level(1)
    plot.axes.set_ylim(bottom=0)
    return plot.markup("Below the dashed line the render is faster. Marks are medians, hollow ones upper quartiles.")


def secondary(results):
    rows = results.get("rows", [])
    about = paragraph(
        "The rays of a render’s first samples, traced again as the render traces them, its tracer included, and by Embree’s calls alone: one "
        "ray a call, or in packets. Processor time of one thread; each ratio is a median over repetitions that took turns."
    )
    ways = list(rows[0].get("nsPerRay", {})) if rows else []
    columns = {"depth, kind": lambda r: words(f"{r.get('depth')}, {r.get('kind')}"), "#rays": "rays", "#render over single": "renderToSingle.median",
               "#lower quartile": "renderToSingle.low", "#upper quartile": "renderToSingle.high", **{"#" + w: f"nsPerRay.{w}.median" for w in ways}}
    listed = listing("Nanoseconds a ray, and the render over single rays", columns, rows)
    return [Section("depths", "By depth and kind", about + secondary_plot(rows) + listed)]


# ---- all ----

BENCHES = {
    "trace": ("Fathom: rays a second of every tracer", trace),
    "render": ("Fathom: the render phase against Embree’s bare calls", render),
    "error": ("Fathom: image error against run time", error),
    "build": ("Fathom: build quality against time", build),
    "growth": ("Fathom: reading, building and tracing by the number of triangles", growth),
    "secondary": ("Fathom: secondary rays against single-ray calls", secondary),
}


def page_of(results):
    title, sections = BENCHES[results["bench"]]
    return page(title, head(results), sections(results))
