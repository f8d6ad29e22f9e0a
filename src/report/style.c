#include "report/style.h"

#include "report/colour.h"

/* Colours by meaning. Those of text keep a contrast of 4.5 to the paper, those of marks 3. */
static const char light[] =
    "--paper:#fff;--ink:#1c2024;--soft:#5a636d;--line:#d4d9df;--faint:#eceff2;--wash:#f5f7f9;"
    "--link:#0a5ca8;--good:#1a6b34;--goodwash:#e9f5ec;--bad:#b3231b;--badwash:#fdecea;"
    "--leak:#8a5a00;--k0:#1668b4;--k1:#b04a0c;--k2:#14795c;--k3:#7d3fb8;--bar:#4a7fb0;"
    "--sign:#fff;--signline:#1c2024";
static const char dark[] =
    "--paper:#14171a;--ink:#e4e7ea;--soft:#a2abb5;--line:#3a4149;--faint:#262b31;--wash:#1b1f24;"
    "--link:#7ab8f5;--good:#6fce8b;--goodwash:#14291b;--bad:#ff8d84;--badwash:#361816;"
    "--leak:#e3b25a;--k0:#62aef0;--k1:#f09a5f;--k2:#4fc8a2;--k3:#c39af0;--bar:#5c93c4;"
    "--sign:#14171a;--signline:#f4f6f8";

static const char rules[] =
    /* text */
    "*{box-sizing:border-box}\n"
    "body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,-apple-system,'Segoe "
    "UI',Roboto,'Liberation Sans','DejaVu Sans',sans-serif}\n"
    "main{max-width:74rem;margin:0 auto;padding:1.5rem 1.25rem 4rem}\n"
    "h1{font-size:1.65rem;line-height:1.2;margin:.5rem 0 1rem;overflow-wrap:anywhere}\n"
    "h2{font-size:1.2rem;margin:3rem 0 .5rem;padding-top:.75rem;border-top:1px solid var(--line)}\n"
    "h3{font-size:.95rem;margin:0 0 .25rem}\n"
    "p{max-width:44rem;margin:.5rem 0 .75rem}\n"
    "a{color:var(--link)}\n"
    "code,pre,svg .label{font-family:ui-monospace,'SF Mono',Menlo,Consolas,'Liberation Mono','DejaVu Sans "
    "Mono',monospace}\n"
    "code{font-size:.92em}\n"
    "pre{font-size:.8rem;line-height:1.45;white-space:pre-wrap;overflow-wrap:anywhere;background:var(--wash);"
    "padding:.6rem .75rem;border-radius:4px;margin:.5rem 0}\n"
    ".verdict{font-size:1.1rem;font-weight:600;max-width:none;padding:.6rem .9rem;border-left:4px solid;"
    "border-radius:2px}\n"
    ".verdict.good{color:var(--good);background:var(--goodwash)}\n"
    ".verdict.bad{color:var(--bad);background:var(--badwash)}\n"
    ".soft,.absent{color:var(--soft)}\n"
    "dl{display:grid;grid-template-columns:max-content 1fr;gap:.2rem 1.25rem;margin:1rem 0;max-width:56rem}\n"
    "dt{color:var(--soft)}dd{margin:0;overflow-wrap:anywhere}\n"
    "nav ul{list-style:none;display:flex;flex-wrap:wrap;gap:.25rem 1.25rem;padding:0;margin:1.25rem 0 0}\n"
    /* tables */
    ".scroll{overflow-x:auto;max-width:100%}\n"
    "table{border-collapse:collapse;font-size:.85rem;font-variant-numeric:tabular-nums;margin:.75rem 0}\n"
    "caption{text-align:left;color:var(--soft);padding-bottom:.35rem}\n"
    "th,td{padding:.22rem .38rem;text-align:left;vertical-align:baseline;white-space:nowrap}\n"
    "th:first-child,td:first-child{padding-left:0}\n"
    "td.wide{white-space:normal;min-width:16rem}\n"
    "thead th{border-bottom:1px solid var(--ink);vertical-align:bottom;font-weight:600;white-space:normal}\n"
    "tbody th{font-weight:400;white-space:normal;overflow-wrap:anywhere;min-width:8.5rem;max-width:22rem}\n"
    /* Names stay in sight while their numbers scroll. */
    "th:first-child{position:sticky;left:0;background:var(--paper)}\n"
    "tbody tr+tr>*{border-top:1px solid var(--faint)}\n"
    "tr.group th{padding-top:1rem;font-weight:600;color:var(--soft)}\n"
    "tr.group code{color:var(--ink)}\n"
    "tr.group th{border-bottom:1px solid var(--line)}\n"
    ".n{text-align:right}\n"
    ".zero{color:var(--soft);opacity:.8}\n"
    "td.bad{color:var(--bad);font-weight:700}td.leak{color:var(--leak);font-weight:600}\n"
    "td.good{color:var(--good)}\n"
    "details{margin:.75rem 0}summary{cursor:pointer;color:var(--link)}\n"
    /* figures */
    ".figures{display:flex;flex-wrap:wrap;gap:1.5rem 2rem;align-items:flex-start;margin:1rem 0}\n"
    "figure{margin:0;max-width:100%;break-inside:avoid}\n"
    "figure h3{overflow-wrap:anywhere}\n"
    "figure svg{display:block;max-width:100%;height:auto}\n"
    "figcaption{font-size:.85rem;color:var(--soft);margin-top:.25rem;width:0;min-width:100%}\n"
    ".listed{display:flex;flex-wrap:wrap;gap:0 1.5rem}.listed ol{margin:1.5rem 0 "
    "0;padding-left:2rem;font-size:.85rem;color:var(--soft);max-width:36rem}\n"
    ".pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(15rem,1fr))}\n"
    ".pictures figure{display:grid;grid-row:span 3;grid-template-rows:subgrid;gap:.25rem}.pictures "
    "h3{align-self:end}\n"
    ".pictures img{display:block;width:100%;height:auto;border:1px solid var(--line)}\n"
    ".legend{list-style:none;display:flex;flex-wrap:wrap;gap:.3rem 1.5rem;padding:0;margin:.75rem 0;"
    "font-size:.85rem}\n"
    ".legend li{display:flex;align-items:center;gap:.35rem}\n"
    ".legend svg{overflow:visible}\n"
    "svg text{font-size:11.5px;fill:var(--soft)}\n"
    "svg "
    "text.label{fill:var(--ink);stroke:var(--paper);stroke-width:3;stroke-linejoin:round;paint-order:stroke}"
    "\n"
    "svg text.axis{fill:var(--ink)}\n"
    ".grid{stroke:var(--faint)}.rule{stroke:var(--soft);fill:none}\n"
    ".solid{stroke:var(--paper);stroke-width:.75}.hollow{fill:var(--paper);stroke-width:1.6}\n"
    ".interval{stroke-width:1.4}.dashed{stroke-dasharray:4 3}.leader{stroke:var(--soft);stroke-width:.7}\n"
    ".bar{fill:var(--bar)}\n"
    ".leak{fill:var(--sign);stroke:var(--signline);stroke-width:1.2}\n"
    ".wrong{stroke:var(--bad);stroke-width:3;fill:none;stroke-linecap:round;paint-order:stroke}\n"
    ".ratio{display:block}.track{fill:var(--faint)}.fine{fill:var(--bar)}.over{fill:var(--bad)}\n"
    ".limit{stroke:var(--ink);stroke-width:1.5}\n";

static const char narrow[] =
    "@media (max-width:40rem){main{padding:1rem .9rem 3rem}dl{grid-template-columns:1fr;gap:0}"
    "dd{margin-bottom:.4rem}h1{font-size:1.35rem}tbody th{max-width:8rem}tr.group th{max-width:none}}\n";
/* Tables are wide: paper lies on its side. */
static const char print[] =
    "@page{size:landscape;margin:12mm}\n"
    "@media print{body{font-size:10pt}main{max-width:none;padding:0}nav{display:none}"
    "table{font-size:8pt}th,td{padding:.12rem .3rem}tbody th{min-width:0}.scroll{overflow:visible}"
    "h2,h3,caption{break-after:avoid}tr{break-inside:avoid}th:first-child{position:static}"
    ".figures{gap:1rem}*{print-color-adjust:exact;-webkit-print-color-adjust:exact}}\n";

static void put_kinds(page *p) {
    for (unsigned k = 0; k < 4; ++k)
        page_put(p, ".k%u.solid{fill:var(--k%u)}.k%u.hollow,.k%u.interval{stroke:var(--k%u)}\n", k, k, k, k,
                 k);
    page_put(p, ".plain.solid{fill:var(--soft)}.plain.hollow{stroke:var(--soft)}\n");
}

static void put_steps(page *p, int dark_paper) {
    for (unsigned i = 0; i < COLOUR_STEPS; ++i) {
        colour c = colour_step(i, dark_paper);
        page_put(p, ".h%u{fill:#%02x%02x%02x}", i, c.r, c.g, c.b);
    }
}

void style_put(page *p) {
    page_put(p, ":root{color-scheme:light dark;%s}\n%s", light, rules);
    put_kinds(p);
    put_steps(p, 0);
    /* Paper is light, whatever the screen is. */
    page_put(p, "\n@media screen and (prefers-color-scheme:dark){:root{%s}\n", dark);
    put_steps(p, 1);
    page_put(p, "}\n%s%s", narrow, print);
}
