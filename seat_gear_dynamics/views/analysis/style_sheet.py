"""The report's looks: system fonts, light and dark by the reader's setting, figures turned dark with it."""

STYLE = """
:root { --ink: #1b1f24; --soft: #5b6570; --paper: #fff; --card: #f5f7f9; --line: #dfe3e8;
  --mark: #0072b2; --warn: #d55e00; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e9ec; --soft: #9aa5b1; --paper: #14171a; --card: #1d2226; --line: #333a41;
    --mark: #56b4e9; --warn: #e69f00; }
  figure img { filter: invert(0.93) hue-rotate(180deg); }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 15px/1.5 system-ui, sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 24px 20px 60px; }
h1 { font-size: 26px; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 19px; margin: 40px 0 8px; border-bottom: 1px solid var(--line); padding-bottom: 4px; }
a { color: var(--mark); }
code, pre { font: 13px/1.45 ui-monospace, monospace; }
pre { overflow: auto; max-height: 480px; background: var(--card); padding: 12px; border-radius: 6px; }
small, .lead { color: var(--soft); }
nav { display: flex; flex-wrap: wrap; gap: 4px 14px; margin: 18px 0 0; font-size: 14px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 10px; margin: 18px 0 0; }
.tiles div { background: var(--card); border-radius: 8px; padding: 10px 14px; display: flex; flex-direction: column; }
.tiles b { font-size: 22px; font-weight: 600; }
.notice { border-left: 4px solid var(--warn); background: var(--card); padding: 8px 14px; margin: 14px 0 0; }
figure { margin: 14px 0 22px; }
figure img { width: 100%; height: auto; border-radius: 6px; background: #fff; }
figcaption { font-size: 14px; margin-top: 4px; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13.5px; font-variant-numeric: tabular-nums; margin: 6px 0; }
th, td { text-align: left; padding: 4px 12px 4px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { color: var(--soft); font-weight: 500; }
#provenance td { overflow-wrap: anywhere; }
@media print { nav { display: none; } figure { break-inside: avoid; } }
"""
