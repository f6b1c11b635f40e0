#include "reports/pages/page_assets.hpp"

#include <string_view>

#include "reports/kit/svg_plot.hpp"

namespace klang::reports::detail {

std::string page_css() {
  static constexpr std::string_view kStyle = R"css(
:root{color-scheme:light dark;--ground:#fbfaf7;--paper:#fff;--ink:#1f2328;--muted:#646b73;--line:#dcdad4;--soft:#f1efe9;
--accent:#0f5f8a;--good:#2e7d4f;--fair:#a36a00;--bad:#b3261e}
@media (prefers-color-scheme:dark){:root{--ground:#101215;--paper:#16181c;--ink:#e7e5e0;--muted:#a0a6ad;--line:#30343a;
--soft:#1d2025;--accent:#6db9e6;--good:#75c796;--fair:#e5b566;--bad:#ff8f85}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%;scroll-behavior:smooth}
body{margin:0;background:var(--ground);color:var(--ink);
font:16px/1.55 system-ui,"Segoe UI",Roboto,"Helvetica Neue","Liberation Sans","DejaVu Sans",sans-serif}
main,header.top,footer{max-width:1128px;margin:0 auto;padding:0 24px}
header.top{padding-top:56px}
.over{margin:0;color:var(--muted);font-size:.8rem;letter-spacing:.09em;text-transform:uppercase}
h1{margin:.15em 0 .35em;font:600 2.5rem/1.15 Charter,"Iowan Old Style","Palatino Linotype",Palatino,Georgia,"DejaVu Serif",serif;
letter-spacing:-.01em;overflow-wrap:anywhere}
h2{margin:3.2rem 0 .6rem;padding-top:1.1rem;border-top:1px solid var(--line);
font:600 1.5rem/1.25 Charter,"Iowan Old Style","Palatino Linotype",Palatino,Georgia,"DejaVu Serif",serif}
h3{margin:1.8rem 0 .4rem;font-size:1.05rem;line-height:1.3;font-weight:600}
p{margin:.5em 0;max-width:74ch}
a{color:var(--accent);text-decoration-thickness:1px;text-underline-offset:2px}
a:focus-visible,button:focus-visible,summary:focus-visible,.scroll:focus-visible{outline:2px solid var(--accent);outline-offset:2px}
.lead{font-size:1.13rem;line-height:1.6;max-width:68ch}
.lead b{font-weight:600;white-space:nowrap}
.verdict{display:flex;flex-wrap:wrap;gap:.4rem .9rem;align-items:baseline;margin:.2rem 0 1.1rem}
.pill{display:inline-flex;align-items:center;gap:.5em;padding:.12em .8em;border-radius:99px;border:1px solid currentColor;font-weight:600;font-size:.9rem}
.pill::before{content:"";width:.6em;height:.6em;border-radius:50%;background:currentColor}
.good{color:var(--good)}.fair{color:var(--fair)}.bad{color:var(--bad)}
.verdict .how{color:var(--muted)}
.keys{display:flex;flex-wrap:wrap;gap:1px;margin:1.6rem 0 .5rem;padding:0;
background:var(--line);border:1px solid var(--line);border-radius:8px;overflow:hidden}
.keys div{flex:1 1 158px;background:var(--paper);padding:.75rem .95rem}
.keys dt{font-size:.8rem;color:var(--muted)}
.keys dd{margin:.1rem 0 0;font-size:1.22rem;font-weight:600;font-variant-numeric:tabular-nums;line-height:1.25}
.keys small{display:block;font-size:.78rem;font-weight:400;color:var(--muted)}
nav.toc{margin:1.4rem 0 0;font-size:.92rem}
nav.toc ol{display:flex;flex-wrap:wrap;gap:.2rem 1.3rem;margin:0;padding:0;list-style:none}
p.how small{color:var(--muted)}
figure{margin:1.2rem 0 1.4rem}
figcaption{margin-top:.45rem;color:var(--muted);font-size:.88rem;line-height:1.5;max-width:92ch}
.sheet{background:var(--paper);border:1px solid var(--line);border-radius:8px;padding:16px;overflow-x:auto}
svg.kf{display:block;width:100%;height:auto;min-width:720px}
.scroll{overflow-x:auto}
table{border-collapse:collapse;font-size:.92rem;font-variant-numeric:tabular-nums;margin:.6rem 0 1rem}
caption{text-align:left;color:var(--muted);font-size:.88rem;padding:.2rem 0 .4rem}
th,td{padding:.36rem .95rem .36rem 0;text-align:left;vertical-align:baseline;border-bottom:1px solid var(--line)}
thead th{font-weight:600;font-size:.82rem;color:var(--muted);vertical-align:bottom}
td.n,th.n{text-align:right;white-space:nowrap}
td.nw{white-space:nowrap}
td.wide{min-width:22ch}
tbody th{font-weight:400}
tr.best td,tr.best th{font-weight:600}
tr.open td,tr.open th{color:var(--muted)}
tr.note td{padding-top:0;color:var(--muted);font-size:.88rem}
tr.pair>*{border-bottom:0}
.sym{font-family:Georgia,"DejaVu Serif",serif;font-style:italic}
.tag{display:inline-block;padding:0 .55em;border-radius:99px;border:1px solid currentColor;font-size:.78rem;white-space:nowrap}
.bar{display:inline-block;height:.55em;background:var(--accent);border-radius:2px;vertical-align:baseline;margin-right:.5em}
aside.warn{margin:1.2rem 0;padding:.7rem 1rem;border-left:3px solid var(--fair);background:var(--soft);border-radius:0 6px 6px 0}
aside.warn h2{all:unset;display:block;font-weight:600;font-size:.95rem}
aside.warn ul{margin:.25rem 0 0;padding-left:1.15rem}
details>summary{cursor:pointer}
details.more{margin:.5rem 0}
details.more>summary{color:var(--accent);font-size:.94rem}
details.body{border-top:1px solid var(--line);padding:.35rem 0}
details.body:last-of-type{border-bottom:1px solid var(--line)}
details.body>summary{padding:.55rem 0;display:grid;grid-template-columns:1.1rem minmax(6rem,auto) 1fr auto;gap:.2rem .9rem;align-items:baseline;list-style:none}
details.body>summary::-webkit-details-marker{display:none}
details.body>summary::before{content:"▸";color:var(--accent)}
details.body[open]>summary::before{content:"▾"}
details.body h3{display:inline;margin:0;overflow-wrap:anywhere}
details.body>summary .shape,details.body>summary .how{color:var(--muted);font-size:.92rem}
.listen{display:flex;flex-wrap:wrap;gap:.9rem 1.6rem;align-items:end;margin:.7rem 0 1rem}
.listen label{display:block;flex:0 1 330px;min-width:240px;font-size:.85rem;color:var(--muted)}
.listen audio{display:block;width:100%;height:40px;margin-top:.2rem}
button{font:inherit;font-size:.92rem;color:var(--accent);background:var(--paper);border:1px solid var(--accent);border-radius:6px;padding:.38rem .9rem;cursor:pointer;min-width:11.5em}
.shapes{display:grid;grid-template-columns:repeat(auto-fill,minmax(240px,1fr));gap:14px;margin:.8rem 0}
.shapes.long{grid-template-columns:repeat(auto-fill,minmax(330px,1fr))}
.shapes figure{margin:0;display:flex;flex-direction:column;justify-content:space-between;background:var(--paper);border:1px solid var(--line);border-radius:8px;padding:12px}
.shapes img{display:block;margin:auto;max-width:100%;height:auto;max-height:220px}
.shapes figcaption{font-size:.85rem}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,440px),1fr));gap:14px;margin:.8rem 0}
.pictures figure{margin:0;background:var(--paper);border:1px solid var(--line);border-radius:8px;padding:12px 14px}
.pictures h3{margin:0 0 .3rem}
.pictures svg.kf{min-width:0}
.shapes b{color:var(--ink);font-weight:600}
pre{overflow-x:auto;background:var(--soft);padding:.8rem 1rem;border-radius:6px;font-size:.82rem;line-height:1.45}
code,.hash{font-family:ui-monospace,"SF Mono",Menlo,Consolas,"Liberation Mono","DejaVu Sans Mono",monospace;font-size:.85em;overflow-wrap:anywhere}
ul.files{columns:2;column-gap:2.5rem;padding-left:1.1rem;font-size:.92rem}
footer{margin-top:3.5rem;padding-bottom:3rem;color:var(--muted);font-size:.85rem}
@media (max-width:640px){.scroll table{min-width:600px}main,header.top,footer{padding-left:16px;padding-right:16px}header.top{padding-top:28px}h1{font-size:1.85rem}
ul.files{columns:1}details.body>summary{grid-template-columns:1.1rem 1fr}details.body>summary .shape,details.body>summary .how{grid-column:2}}
@media print{:root{color-scheme:light;--ground:#fff;--paper:#fff;--ink:#000;--muted:#444;--line:#bbb;--soft:#f4f4f4;--accent:#0f5f8a}
body{font-size:10.5pt}header.top{padding-top:0}nav.toc,.listen{display:none}h2{break-after:avoid;margin-top:1.6rem}
figure,table,.keys{break-inside:avoid}.sheet{border:0;padding:0;overflow:visible}svg.kf{min-width:0}a{color:inherit;text-decoration:none}}
)css";
  return std::string(kStyle) + figure_css(false) + "@media screen and (prefers-color-scheme:dark){\n" +
         figure_css(true) + "}\n";
}

std::string page_script() {
  // One button per specimen plays both clips in step and lets one of them be heard; closed parts open for the
  // printer.
  return R"js("use strict";
document.querySelectorAll("[data-switch]").forEach(function(box){
  var sounds=box.querySelectorAll("audio"),button=box.querySelector("button"),heard=-1;
  if(sounds.length<2||!button)return;
  button.hidden=false;
  var names=[].map.call(box.querySelectorAll("label"),function(l){return l.firstChild.textContent.toLowerCase();});
  function say(){button.textContent=heard<0?"Play both, compare":"Hearing "+names[heard]+" – switch";}
  button.addEventListener("click",function(){
    if(heard<0){heard=0;sounds[0].currentTime=0;sounds[1].currentTime=0;}
    else{heard=1-heard;sounds[heard].currentTime=sounds[1-heard].currentTime;}
    sounds[heard].muted=false;sounds[1-heard].muted=true;
    sounds.forEach(function(sound){if(sound.paused)sound.play().catch(function(){});});
    say();
  });
  function stop(){heard=-1;sounds.forEach(function(sound){sound.muted=false;});say();}
  sounds[0].addEventListener("ended",function(){sounds[1].pause();stop();});
  say();
});
window.addEventListener("beforeprint",function(){
  document.querySelectorAll("details.body").forEach(function(part){part.open=true;});
});
)js";
}

}  // namespace klang::reports::detail
