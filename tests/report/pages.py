"""Laws of the pages that src/report/ draws: everything in the results is on the page, nothing in them becomes markup, and the
page asks for nothing from outside."""

import copy
import json
import re
import sys
import unittest
from html.parser import HTMLParser
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent.parent / "src" / "report"))

import bench_page  # noqa: E402
import html_page  # noqa: E402
import results  # noqa: E402
import validate_page  # noqa: E402

VOID = {"meta", "link", "img", "br", "path", "use", "rect"}


class Document(HTMLParser):
    """Counts elements, and refuses tags that do not match and everything that loads or runs."""

    def __init__(self, markup):
        super().__init__()
        self.open, self.counts, self.texts, self.faults, self.ids = [], {}, [], [], []
        self.feed(markup)
        self.close()
        if self.open:
            self.faults.append(f"not closed: {self.open}")

    def handle_starttag(self, tag, attributes):
        self.counts[tag] = self.counts.get(tag, 0) + 1
        if tag in ("script", "iframe", "object", "embed", "foreignobject"):
            self.faults.append(f"<{tag}>")
        for name, value in attributes:
            if name.startswith("on"):
                self.faults.append(f"{tag} {name}")
            if name in ("src", "href", "xlink:href") and not re.match(r"#|data:", value or ""):
                self.faults.append(f"{tag} {name}={value}")
            if name == "id":
                self.ids.append(value)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag in VOID:
            return
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> does not match")

    def handle_data(self, data):
        self.texts.append(data)


def load(name):
    return json.loads((HERE / name).read_text(encoding="utf-8"))


class ValidatePage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.results = load("full.json")
        cls.markup = validate_page.page_of(cls.results)
        cls.document = Document(cls.markup)

    def test_tags_match_and_nothing_is_loaded_or_run(self):
        self.assertEqual(self.document.faults, [])

    def test_names_that_look_like_markup_stay_text(self):
        names = {run["scene"] for run in self.results["runs"]}
        self.assertTrue(any("<script>" in name for name in names))
        for name in names:
            self.assertIn(name, "".join(self.document.texts))

    def test_every_tracer_has_a_point_in_each_plot(self):
        for spec in results.tracers_of(self.results["runs"]):
            self.assertEqual(self.markup.count(f"<title>{html_page.text(spec)}: "), 2, spec)

    def test_every_ray_is_in_a_histogram(self):
        for spec in results.tracers_of(self.results["runs"]):
            own = [r for r in self.results["runs"] if r["spec"] == spec]
            spread = results.Spread(f["tUlps"] for f in results.families_of(own))
            in_bins = sum(sum(f["tUlps"]["histogram"]["bins"]) for f in results.families_of(own))
            self.assertEqual(sum(n for _, n in spread.octaves()), in_bins)
            self.assertEqual(spread.total, in_bins + spread.zeros)

    def test_every_extreme_case_is_on_a_map_and_in_the_table(self):
        for name in {c["group"] for c in self.results["extremes"]}:
            self.assertIn(f"<h3>{html_page.text(name)}</h3>", self.markup)
        everything = self.markup[self.markup.index("Every extreme case") :]
        rows = everything[: everything.index("</table>")]
        self.assertEqual(rows.count('<th scope="row">'), len(self.results["extremes"]))

    def test_every_shading_case_is_shown(self):
        self.assertEqual(self.markup.count('class="ratio"'), len(self.results["shading"]) + len({c["group"] for c in self.results["shading"]}))

    def test_ids_are_unique(self):
        named = [i for i in self.document.ids if not re.match(r"(figure|axes|patch|matplotlib|xtick|ytick|line2d|text|PathCollection|legend|m[0-9a-f]{10}|p[0-9a-f]{10}|mark)", i)]
        self.assertEqual(len(named), len(set(named)))

    def test_the_verdict_counts_what_the_runs_count(self):
        clean = copy.deepcopy(self.results)
        self.assertIn('class="verdict bad"', self.markup)
        for run in clean["runs"]:
            for family in run["families"]:
                family["verdicts"]["wrong"] = 0
                family.get("any", {}).get("verdicts", {}).pop("wrong", None)
                family.get("others", {}).get("verdicts", {}).pop("wrong", None)
            run["findings"] = []
        clean["extremes"], clean["shading"] = [], []
        self.assertIn("Nothing wrong in", validate_page.page_of(clean))
        clean["runs"][0]["findings"] = ["bias: t is off by <much>"]
        found = validate_page.page_of(clean)
        self.assertIn("1 statistic out of bounds in", found)
        self.assertIn("bias: t is off by &lt;much&gt;", found)
        clean["runs"][0]["findings"] = []
        clean["runs"][0]["families"][0]["others"] = {"verdicts": {"wrong": 3}}
        self.assertIn("3 answers wrong in", validate_page.page_of(clean))

    def test_equal_results_give_equal_pages(self):
        self.assertEqual(self.markup, validate_page.page_of(copy.deepcopy(self.results)))

    def test_missing_parts_are_said(self):
        markup = validate_page.page_of(load("early.json"))
        self.assertEqual(Document(markup).faults, [])
        self.assertGreaterEqual(markup.count('class="absent"'), 5)


class Numbers(unittest.TestCase):
    def test_three_digits_and_powers_of_ten(self):
        shown = {0.0: "0", 1.0: "1", 0.0123: "0.0123", 1234.0: "1230", 99999.0: "10⁵", 3.9e8: "3.9×10⁸", -2.5: "−2.5", 1e-8: "10⁻⁸"}
        for value, said in shown.items():
            self.assertEqual(html_page.number(value), said)
        self.assertEqual(html_page.number(float("nan")), "–")
        self.assertEqual(html_page.count(1234567), "1\u202f234\u202f567")
        self.assertEqual(html_page.count(1234), "1234")

    def test_quantiles_lie_in_their_bin_and_below_the_largest_value(self):
        spread = results.Spread([{"max": {"value": 5.0}, "histogram": {"zeros": 10, "first": 0, "perOctave": 1, "bins": [80, 9, 1]}}])
        self.assertEqual(spread.quantile(0.1), 0)
        self.assertEqual(spread.quantile(0.5), 2)
        self.assertEqual(spread.quantile(1.0), 5)


class BenchPages(unittest.TestCase):
    def test_every_bench_has_a_page_of_matching_tags(self):
        for name in bench_page.BENCHES:
            data = load(f"bench_{name}.json")
            markup = bench_page.page_of(data)
            self.assertEqual(Document(markup).faults, [], name)
            for key in ("fathom", "date"):
                self.assertIn(html_page.text(data[key]), markup)

    def test_every_image_of_a_curve_is_a_point_in_three_plots(self):
        data = load("bench_error.json")
        points = sum(len(c["points"]) for c in data["curves"])
        self.assertEqual(bench_page.page_of(data).count(" samples a pixel: "), 3 * points)

    def test_every_tracer_and_size_is_a_point_in_six_plots(self):
        data = load("bench_trace.json")
        for run in data["runs"]:
            run["bvhBytes"] = run["bvhBytes"] or 1  # no logarithmic axis has a place for 0
        self.assertEqual(len(re.findall(r"<title>[^<]* triangles: ", bench_page.page_of(data))), 6 * len(data["runs"]))

    def test_every_run_of_several_sizes_is_a_point_in_five_plots(self):
        data = load("bench_render.json")
        self.assertEqual(len(re.findall(r"<title>[^<]* triangles: ", bench_page.page_of(data))), 5 * len(data["runs"]))
        data["runs"], data["fits"] = data["runs"][:1], []
        self.assertIn("One size only", bench_page.page_of(data))


if __name__ == "__main__":
    unittest.main()
