"""Plots by matplotlib, as SVG inside a page. Text and axes take the colours of the page, on light and dark paper."""

import io
import math

import matplotlib
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from html_page import number, power, text

# Each has a contrast of at least 3 with white and with the dark paper.
COLOURS = ["#1f77b4", "#d1600f", "#258f63", "#9467bd", "#b8860b", "#c44e52", "#17889e", "#7f7f7f", "#6b8e23", "#a0522d"]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "<", ">", "p"]
# Placeholders in matplotlib; the page replaces them by its own colours: see style.css.
INK, SOFT, LINE, PAPER = "#010203", "#010204", "#010205", "#010206"
PAGE_COLOURS = {INK: "var(--ink)", SOFT: "var(--soft)", LINE: "var(--line)", PAPER: "var(--paper)"}

matplotlib.rcParams.update(
    {
        "svg.fonttype": "none",
        "font.family": "DejaVu Sans",
        "font.size": 12,
        "text.color": INK,
        "axes.edgecolor": SOFT,
        "axes.labelcolor": INK,
        "axes.facecolor": "none",
        "figure.facecolor": "none",
        "xtick.color": SOFT,
        "ytick.color": SOFT,
        "grid.color": LINE,
        "legend.frameon": False,
    }
)


def usable(x):
    return x is not None and math.isfinite(x)


class Plot:
    """Points and lines on two logarithmic axes; a point shows its numbers when the pointer is over it."""

    def __init__(self, title, x_name, y_name, *, summary, size=(1040, 400)):
        self.title, self.summary = title, summary
        self.titles = {}
        self.figure = Figure(figsize=(size[0] / 72, size[1] / 72), layout="constrained")
        self.axes = self.figure.add_subplot()
        self.axes.set_xlabel(x_name)
        self.axes.set_ylabel(y_name)
        self.axes.grid(True, linewidth=0.6)
        self.axes.set_axisbelow(True)
        for axis, scale in ((self.axes.xaxis, self.axes.set_xscale), (self.axes.yaxis, self.axes.set_yscale)):
            scale("log")
            axis.set_major_formatter(lambda x, _: power(round(math.log10(x))) if not 0.001 <= x < 10000 else number(x))
            axis.set_minor_formatter(NullFormatter())
            axis.set_minor_locator(LogLocator(subs=(2, 5)))

    def _shown(self, x, y):
        return usable(x) and usable(y) and x > 0 and y > 0

    def point(self, x, y, title, *, series=0, high=None, hollow=False, label=None):
        """high: the end of an interval above the point."""
        if not self._shown(x, y):
            return
        colour = COLOURS[series % len(COLOURS)]
        marker = MARKERS[(series + series // len(COLOURS)) % len(MARKERS)]  # a hundred pairs
        if self._shown(x, high):
            self.axes.plot([x, x], [y, high], color=colour, linewidth=1.2)
            self.axes.plot([x], [high], marker=marker, color=colour, markerfacecolor=PAPER, markersize=6)
        (artist,) = self.axes.plot(
            [x], [y], marker=marker, linestyle="none", color=colour, markerfacecolor=PAPER if hollow else colour, markersize=7, label=label
        )
        artist.set_gid(f"mark{len(self.titles)}")
        self.titles[artist.get_gid()] = title

    def line(self, xs, ys, *, series=0, dashed=False):
        pairs = [(x, y) for x, y in zip(xs, ys) if self._shown(x, y)]
        if len(pairs) > 1:
            self.axes.plot(*zip(*pairs), color=COLOURS[series % len(COLOURS)], linewidth=1.2, linestyle="--" if dashed else "-")

    def bars(self, items, series=0):
        """items: (from, to, height, title)"""
        for low, high, height, title in items:
            (bar,) = self.axes.bar(low, height, width=high - low, align="edge", color=COLOURS[series], edgecolor=PAPER, linewidth=0.4)
            bar.set_gid(f"mark{len(self.titles)}")
            self.titles[bar.get_gid()] = title

    def _legend(self):
        handles, labels = self.axes.get_legend_handles_labels()
        if labels:
            self.axes.legend(handles, labels, loc="lower left", bbox_to_anchor=(0, 1), ncol=min(4, len(labels)), prop={"size": 11})

    def _ticks(self):
        """Powers of ten alone are too few on an axis of less than two decades."""
        for axis, ends in ((self.axes.xaxis, self.axes.get_xlim()), (self.axes.yaxis, self.axes.get_ylim())):
            if ends[1] < 100 * ends[0]:
                axis.set_minor_formatter(lambda x, _: number(x))

    def markup(self, caption=""):
        """A figure with its title, and caption; both are escaped here."""
        self._legend()
        self._ticks()
        out = io.StringIO()
        with matplotlib.rc_context({"svg.hashsalt": self.title + self.summary}):
            self.figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
        svg = out.getvalue()
        svg = svg[svg.index("<svg") :]
        opening = svg[: svg.index(">") + 1]
        view = opening.split('viewBox="')[1].split('"')[0]
        width, height = view.split()[2:]
        head = f'<svg role="img" viewBox="{view}" width="{width}" height="{height}" xmlns:xlink="http://www.w3.org/1999/xlink"><title>{text(self.summary)}</title>'
        svg = head + svg[len(opening) :]
        for gid, title in self.titles.items():
            svg = svg.replace(f'<g id="{gid}">', f'<g class="mark"><title>{text(title)}</title>', 1)
        for colour, variable in PAGE_COLOURS.items():
            svg = svg.replace(colour, variable)
        below = f"<figcaption>{text(caption)}</figcaption>" if caption else ""
        return f"<figure>\n<h3>{text(self.title)}</h3>\n{svg}{below}</figure>\n"


def side_by_side(figures):
    return '<div class="figures">\n' + "".join(figures) + "</div>\n"
