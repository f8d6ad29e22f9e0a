"""HTML: text, numbers, tables and the frame of a page. Everything from outside is escaped here."""

import html
import math
from pathlib import Path

THIN = "\u202f"
MINUS = "\u2212"
GENERATOR = '<meta name="generator" content="fathom'
SUPERSCRIPT = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")


def text(value):
    return html.escape(str(value), quote=True)


def count(n):
    """All digits, in groups of three from five digits on."""
    plain = str(int(n))
    return f"{int(n):,}".replace(",", THIN) if len(plain) > 4 else plain


def number(x):
    """Three digits: 0.0123, 1230, 3.9×10⁸. A missing number is an en dash."""
    if x is None or math.isnan(x):
        return "\u2013"
    if math.isinf(x):
        return "\u221e" if x > 0 else MINUS + "\u221e"
    if x == 0:
        return "0"
    digits, exponent = f"{abs(x):.2e}".split("e")
    sign, exponent = MINUS if x < 0 else "", int(exponent)
    if -3 < exponent < 4:
        shown = f"{float(digits) * 10**exponent:.{max(0, 2 - exponent)}f}"
        return sign + (shown.rstrip("0").rstrip(".") if "." in shown else shown)
    mantissa = digits.rstrip("0").rstrip(".")
    return sign + ("" if mantissa == "1" else mantissa + "\u00d7") + power(exponent)


def power(exponent):
    return "10" + str(exponent).translate(SUPERSCRIPT)


# ---- cells ----


class Cell:
    """A cell of a table: escaped markup and its class."""

    def __init__(self, markup, kind="", head=False):
        self.markup, self.kind, self.head = markup, kind, head


def words(value):
    return Cell(text(value))


def code(value):
    return Cell(f"<code>{text(value)}</code>")


def num(x):
    return Cell("" if x is None or math.isnan(x) else number(x), "n")


def exact(x):
    """All digits of a float, for values that are compared."""
    return Cell("" if x is None or math.isnan(x) else f"{x:.9g}", "n")


def whole(n, mark=""):
    """A count; 0 is a dot, so that other values stand out. mark: the class of counts above 0."""
    return Cell(count(n), "n " + mark) if n else Cell("\u00b7", "n zero")


def passed(ok):
    return Cell("ok", "good") if ok else Cell("failed", "bad")


def _row(cells):
    first, rest = cells[0], cells[1:]
    items = [f'<th scope="row">{first.markup}</th>']
    items += [f'<td class="{c.kind.strip()}">{c.markup}</td>' if c.kind else f"<td>{c.markup}</td>" for c in rest]
    return "<tr>" + "".join(items) + "</tr>\n"


def table(caption, columns, rows):
    """columns: names; those that begin with "#" hold numbers. rows: lists of cells, or markup for the head of a group."""
    heads = "".join(f'<th scope="col" class="{"n" if c.startswith("#") else ""}">{text(c.lstrip("#"))}</th>' for c in columns)
    body = []
    for row in rows:
        if isinstance(row, str):
            body.append(f'<tr class="group"><th colspan="{len(columns)}" scope="rowgroup">{row}</th></tr>\n')
        else:
            body.append(_row(row))
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{text(caption)}">\n<table>\n'
        f"<caption>{text(caption)}</caption>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{''.join(body)}</tbody>\n"
        "</table>\n</div>\n"
    )


def group(name, description=""):
    """The head of a group of rows: a name as code, or words alone."""
    head = f"<code>{text(name)}</code>" if name else ""
    return head + (" " if head and description else "") + text(description)


# ---- pages ----


def details(summary, markup):
    return f"<details><summary>{text(summary)}</summary>\n{markup}</details>\n"


def absent(sentence):
    return f'<p class="absent">{text(sentence)}</p>\n'


def paragraph(markup):
    return f"<p>{markup}</p>\n"


def facts(pairs):
    """A list of terms; pairs whose value is empty are left out. Values are markup."""
    items = "".join(f"<dt>{text(name)}</dt><dd>{value}</dd>\n" for name, value in pairs if value)
    return f"<dl>\n{items}</dl>\n"


def machine_facts(results):
    """Pairs about the program and the machine that the results are of."""
    machine = results.get("machine", {})
    named = {"Fathom": results.get("fathom"), "Commit": results.get("commit"), "Date": results.get("date"), "Processor": machine.get("cpu"),
             "Processors": machine.get("processors"), "Threads": machine.get("threads"), "Load at the start": machine.get("load"),
             "Embree": machine.get("embree"), "Kernels": machine.get("kernels"), "Compiler": machine.get("compiler"), "Flags": machine.get("flags")}
    return [(name, number(value) if isinstance(value, (int, float)) else text(value or "")) for name, value in named.items()]


class Section:
    def __init__(self, name, heading, markup):
        self.name, self.heading, self.markup = name, heading, markup


def page(title, head, sections):
    """A document that needs nothing else: no script, no network, plots as SVG inside it."""
    links = "".join(f'<li><a href="#{s.name}">{text(s.heading)}</a></li>\n' for s in sections)
    body = "".join(
        f'<section id="{s.name}" aria-labelledby="{s.name}-heading">\n<h2 id="{s.name}-heading">{text(s.heading)}</h2>\n'
        f"{s.markup}</section>\n"
        for s in sections
    )
    style = (Path(__file__).parent / "style.css").read_text(encoding="utf-8")
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n{GENERATOR}">\n'
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:\">\n"
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n<link rel="icon" href="data:,">\n'
        f"<title>{text(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n<h1>{text(title)}</h1>\n"
        f'<section>\n{head}<nav aria-label="Sections"><ul>\n{links}</ul></nav>\n</section>\n{body}</main>\n</body>\n</html>\n'
    )
