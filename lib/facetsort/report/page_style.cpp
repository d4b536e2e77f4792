#include "facetsort/report/page_style.h"

namespace facetsort {

// Rates are coloured in classes .rate0 (none wrong) to .rate5 (half or more), from blue over sand to dark red: an order
// that survives every common kind of colour blindness. Text on each has a contrast of at least 4.5.
const std::string_view page_style = R"css(
:root {
  color-scheme: light dark;
  --page: #ffffff; --panel: #f5f6f8; --line: #d9dce2; --text: #1b1e24; --muted: #5b626e; --link: #0b5cad;
  --good: #0f6b4f; --good-panel: #e3f4ee; --bad: #9a3412; --bad-panel: #fdeee4;
  --rate0: #1d5fa8; --rate0-text: #fff; --rate1: #a9cdee; --rate1-text: #10263d; --rate2: #f3ead0; --rate2-text: #3b3013;
  --rate3: #f6c878; --rate3-text: #402a00; --rate4: #d9622b; --rate4-text: #000; --rate5: #7d1420; --rate5-text: #fff;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14161a; --panel: #1d2026; --line: #343943; --text: #e8eaee; --muted: #a2a9b5; --link: #7db8f5;
    --good: #6fd3ae; --good-panel: #14302a; --bad: #f5a97b; --bad-panel: #33211a;
    --rate0: #2f7fd1; --rate0-text: #000; --rate1: #1f4468; --rate1-text: #d9ebfb; --rate2: #3d3728; --rate2-text: #f3ead0;
    --rate3: #7a5413; --rate3-text: #fff; --rate4: #d9622b; --rate4-text: #000; --rate5: #8f1726; --rate5-text: #fff;
  }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; scroll-behavior: smooth; }
@media (prefers-reduced-motion: reduce) { html { scroll-behavior: auto; } }
body {
  margin: 0; background: var(--page); color: var(--text);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif;
}
main, header, footer { max-width: 1360px; margin: 0 auto; padding: 0 24px; }
header { padding-top: 32px; }
footer { padding-top: 24px; padding-bottom: 48px; color: var(--muted); font-size: 14px; }
h1 { font-size: 32px; line-height: 1.2; margin: 0 0 8px; letter-spacing: -0.01em; }
h2 { font-size: 24px; line-height: 1.25; margin: 0 0 8px; overflow-wrap: anywhere; }
h3 { font-size: 17px; margin: 24px 0 8px; }
p { margin: 0 0 12px; max-width: 75ch; }
a { color: var(--link); }
code { font: 0.9em/1.45 ui-monospace, SFMono-Regular, Menlo, Consolas, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
.muted { color: var(--muted); }
.facts { color: var(--muted); font-size: 15px; max-width: none; }
nav ul { list-style: none; display: flex; flex-wrap: wrap; gap: 8px; margin: 16px 0 0; padding: 0; }
nav a {
  display: block; max-width: 100%; padding: 5px 12px; border: 1px solid var(--line); border-radius: 999px;
  text-decoration: none; font-size: 14px; overflow-wrap: anywhere;
}
nav a:hover, nav a:focus-visible { background: var(--panel); }
section { padding: 32px 0 16px; }
section + section { border-top: 1px solid var(--line); margin-top: 24px; }
.verdict {
  padding: 14px 18px; border-left: 5px solid var(--good); border-radius: 6px; background: var(--good-panel); margin: 12px 0 16px;
}
.verdict.none { border-color: var(--bad); background: var(--bad-panel); }
.verdict p { margin: 0; max-width: none; overflow-wrap: anywhere; }
.verdict p + p { margin-top: 6px; }
.verdict .headline { font-size: 20px; font-weight: 650; line-height: 1.35; }
.verdict .headline b { color: var(--good); }
.verdict.none .headline b { color: var(--bad); }
.box { border: 1px solid var(--line); border-radius: 8px; background: var(--panel); padding: 14px 18px; margin-top: 20px; }
.box dl { display: grid; grid-template-columns: max-content 1fr; gap: 6px 18px; margin: 10px 0 0; max-width: 110ch; }
.box dt { font-weight: 650; }
.box dd { margin: 0; }
summary { cursor: pointer; font-weight: 600; }
details.table { margin: 16px 0; }
details.table > .scroll { margin-top: 10px; }
.scroll { overflow-x: auto; border: 1px solid var(--line); border-radius: 8px; max-width: 100%; }
table { border-collapse: separate; border-spacing: 0; font-size: 14px; font-variant-numeric: tabular-nums; width: 100%; }
th, td { padding: 6px 10px; text-align: right; white-space: nowrap; }
thead th { vertical-align: bottom; font-weight: 600; background: var(--panel); border-bottom: 1px solid var(--line); }
thead th small { display: block; font-weight: 400; color: var(--muted); }
tbody th { font-weight: 400; min-width: 264px; }
tbody tr + tr > * { border-top: 1px solid var(--line); }
th:first-child { text-align: left; position: sticky; left: 0; background: var(--page); z-index: 1; border-right: 1px solid var(--line); }
thead th:first-child { background: var(--panel); }
tr.taken > th { font-weight: 700; }
.heat td.rate { text-align: center; min-width: 62px; border-left: 2px solid var(--page); font-weight: 500; }
.heat tbody tr > * { border-top: 2px solid var(--page); }
.heat thead th.mesh { text-align: center; padding: 8px 4px; }
.heat thead th.mesh a { writing-mode: vertical-rl; transform: rotate(180deg); max-height: 170px; overflow: hidden; text-overflow: ellipsis; }
.rate0 { background: var(--rate0); color: var(--rate0-text); }
.rate1 { background: var(--rate1); color: var(--rate1-text); }
.rate2 { background: var(--rate2); color: var(--rate2-text); }
.rate3 { background: var(--rate3); color: var(--rate3-text); }
.rate4 { background: var(--rate4); color: var(--rate4-text); }
.rate5 { background: var(--rate5); color: var(--rate5-text); }
.star { font-weight: 700; }
td .star::before { content: "\2605\00a0"; }
.scale { display: flex; flex-wrap: wrap; gap: 4px 0; list-style: none; padding: 0; margin: 10px 0 16px; font-size: 13px; align-items: center; }
.scale li { padding: 2px 10px; }
.scale li.note { padding-left: 14px; }
.ramp { display: inline-block; width: 190px; max-width: 100%; height: 14px; border-radius: 3px; vertical-align: -2px; margin: 0 6px; }
.columns { display: grid; grid-template-columns: minmax(0, 1fr) minmax(0, 1fr); gap: 8px 32px; align-items: start; }
figure { margin: 0; min-width: 0; }
figcaption { font-size: 14px; }
.plot { display: block; width: 100%; height: auto; max-width: 560px; }
.plot text { fill: var(--muted); }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: 4px 18px; padding: 0; margin: 8px 0; font-size: 14px; }
.legend li { overflow-wrap: anywhere; }
.columns > .legend { flex-direction: column; margin: 12px 0; }
.mark { width: 14px; height: 14px; vertical-align: -2px; margin-right: 7px; flex: none; overflow: visible; }
.hidden { position: absolute; width: 0; height: 0; overflow: hidden; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(196px, 1fr)); gap: 24px 16px; margin-top: 8px; }
.pictures figure { display: flex; flex-direction: column; gap: 4px; }
.pictures img { display: block; width: 100%; height: auto; background: #000; border-radius: 4px; }
.pictures .same {
  display: flex; align-items: center; justify-content: center; text-align: center; padding: 8px; border-radius: 4px;
  border: 1px dashed var(--line); color: var(--muted); font-size: 14px;
}
.pictures figcaption { display: flex; flex-direction: column; line-height: 1.4; padding-top: 2px; }
.pictures figcaption strong { font-weight: 600; overflow-wrap: anywhere; }
.pictures .taken figcaption strong::after { content: " \2605"; color: var(--good); }
.pictures figcaption span { color: var(--muted); font-variant-numeric: tabular-nums; }
a:focus-visible, summary:focus-visible { outline: 3px solid var(--link); outline-offset: 2px; border-radius: 3px; }
@media (max-width: 760px) {
  main, header, footer { padding-left: 16px; padding-right: 16px; }
  h1 { font-size: 26px; }
  h2 { font-size: 21px; }
  .verdict .headline { font-size: 18px; }
  .columns { grid-template-columns: minmax(0, 1fr); }
  .box dl { display: block; }
  .box dt { margin-top: 8px; }
  tbody th, thead th:first-child { min-width: 132px; max-width: 152px; white-space: normal; overflow-wrap: break-word; }
  .pictures { grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 20px 12px; }
  .pictures figcaption { font-size: 13px; }
}
@media print { details.table > .scroll { overflow: visible; } nav { display: none; } }
)css";

// Long tables start folded on phones.
const std::string_view page_script = R"js(
if (matchMedia('(max-width: 760px)').matches) {
  for (const table of document.querySelectorAll('details.table')) table.open = false;
}
)js";

}  // namespace facetsort
