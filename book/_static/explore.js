/* Figures to zoom and to read values from: the data lies in the page, Plotly is one file of this book, loaded when first asked for. */
(function () {
  "use strict";
  const here = document.currentScript.src;
  let library = null;
  function plotly() {
    library = library || new Promise((done, failed) => {
      const script = document.createElement("script");
      script.src = here.replace(/explore\.js.*$/, "plotly.min.js");
      script.onload = () => done(window.Plotly);
      script.onerror = failed;
      document.head.appendChild(script);
    });
    return library;
  }
  const axes = (layout, letter) => Object.keys(layout).filter((key) => new RegExp("^" + letter + "axis\\d*$").test(key));
  const copy = (value) => JSON.parse(JSON.stringify(value));

  // the data with an axis in SI instead of the datasheet's unit
  function inUnits(figure, si) {
    const { data, layout } = copy(figure);
    if (!si) return { data, layout };
    for (const [key, [factor, unit]] of Object.entries(figure.si)) {
      const axis = layout[key], letter = key[0], name = key.replace("axis", "");
      const shift = (v) => (axis.type === "log" ? v + Math.log10(factor) : v * factor);
      const label = axis.title.text;
      axis.range = axis.range.map(shift);
      axis.title.text = label.slice(0, label.lastIndexOf(", ") + 2) + unit;
      for (const trace of data) {
        if (trace[letter + "axis"] !== name) continue;
        trace[letter] = trace[letter].map((v) => (v === null ? v : v * factor));
      }
      for (const shape of layout.shapes) if (shape[letter + "ref"] === name) {
        shape[letter + "0"] *= factor; shape[letter + "1"] *= factor;
      }
      for (const words of layout.annotations) if (words[letter + "ref"] === name) words[letter] *= factor;
    }
    return { data, layout };
  }

  // what a label under the pointer says: each axis by name, with its unit; no number for an axis of names
  function told(trace, layout) {
    const lines = [];
    for (const letter of ["x", "y"]) {
      const axis = layout[trace[letter + "axis"].replace(letter, letter + "axis")];
      if (axis.tickvals) continue;
      const label = axis.title.text, at = label.lastIndexOf(", "), last = label.slice(at + 2);
      const parted = at > 0 && last.split("(").length === last.split(")").length;
      const name = (parted ? label.slice(0, at) : label).replace(/^[^:]*: (?=\S)/, "");
      lines.push(name + " %{" + letter + ":.4~g}" + (parted ? " " + last : ""));
    }
    return lines.join("<br>") + "<extra>" + trace.name + "</extra>";
  }

  function draw(stage, figure, state) {
    const { data, layout } = inUnits(figure, state.si);
    for (const letter of ["x", "y"]) for (const key of axes(layout, letter)) {
      const axis = layout[key];
      axis.automargin = true;
      axis.zeroline = false;
      axis.gridcolor = "#dddddd";
      axis.exponentformat = "power";
      if (axis.type === "log") axis.dtick = "D1";
      if (axis.type === "log" && Math.abs(axis.range[1] - axis.range[0]) > 1.5) axis.dtick = 1;
      if (state[letter] && state[letter] !== axis.type && !axis.tickvals) {
        axis.type = state[letter];
        delete axis.dtick;
        delete axis.range;
      }
    }
    for (const shape of layout.shapes) for (const letter of ["x", "y"]) {
      const key = (shape[letter + "ref"].split(" ")[0]).replace(letter, letter + "axis");
      if (layout[key] && layout[key].type === "log" && !/domain/.test(shape[letter + "ref"])) {
        shape[letter + "0"] = Math.max(shape[letter + "0"], 1e-300); shape[letter + "1"] = Math.max(shape[letter + "1"], 1e-300);
      }
    }
    for (const words of layout.annotations) for (const letter of ["x", "y"]) {
      const key = words[letter + "ref"].replace(letter, letter + "axis");
      if (layout[key] && layout[key].type === "log") words[letter] = Math.log10(words[letter]);
    }
    for (const trace of data) if (trace.hoverinfo !== "skip") trace.hovertemplate = told(trace, layout);
    const narrow = stage.clientWidth < 560;
    const panels = axes(layout, "x").length;
    if (narrow && panels > 1) stack(layout);
    else hideRepeated(layout);
    const tall = narrow ? 300 * panels + 80 : Math.round(Math.min(stage.clientWidth, 900) * figure.aspect) + 60;
    Object.assign(layout, {
      height: Math.max(380, tall),
      margin: { l: 60, r: 12, t: 36, b: narrow ? 130 : 100 },
      font: { family: getComputedStyle(stage).fontFamily, size: narrow ? 11 : 13, color: "#222222" },
      paper_bgcolor: "#ffffff", plot_bgcolor: "#ffffff", hovermode: "closest", barmode: "overlay", dragmode: "zoom",
      hoverlabel: { font: { size: 13 } },
      legend: { orientation: "h", y: 0, yref: "container", yanchor: "bottom" },
    });
    return window.Plotly.react(stage, data, layout, { displaylogo: false, responsive: true });
  }

  // one panel under the other where the page is narrow
  function stack(layout) {
    const keys = axes(layout, "x");
    keys.forEach((key, number) => {
      const top = 1 - number / keys.length, room = number < keys.length - 1 ? 0.25 / keys.length : 0;
      layout[key].domain = [0, 1];
      layout[key.replace("x", "y")].domain = [top - 1 / keys.length + room, top];
    });
  }

  // a label that stands at the panel to the left as well says nothing new
  function hideRepeated(layout) {
    const first = {};
    for (const key of axes(layout, "y")) {
      const row = layout[key].domain.join(), label = layout[key].title.text;
      if (first[row] === label) layout[key].title.text = "";
      else first[row] = label;
    }
  }

  function button(text, title, act) {
    const made = document.createElement("button");
    made.type = "button";
    made.className = "explore";
    made.textContent = text;
    made.title = title;
    made.addEventListener("click", () => act(made));
    return made;
  }

  function offer(source) {
    const output = source.closest(".cell_output");
    const image = output && output.querySelector("img");
    if (!image) return;
    const figure = JSON.parse(source.textContent);
    const still = image.closest("a.image-reference, a.reference") || image;
    const stage = document.createElement("div");
    stage.className = "explored";
    stage.hidden = true;
    const bar = document.createElement("div");
    bar.className = "explore-bar";
    const state = { x: "", y: "", si: false };
    const switches = ["x", "y"].map((letter) => {
      const first = figure.layout[letter + "axis"].type, other = first === "log" ? "linear" : "log";
      const says = (type) => letter + " axis: " + (type === "log" ? "logarithmic" : "linear");
      return button(says(first), "Switch between a linear and a logarithmic axis", (self) => {
        state[letter] = state[letter] === other ? first : other;
        self.textContent = says(state[letter]);
        draw(stage, figure, state);
      });
    });
    const units = Object.keys(figure.si).length
      ? [button("units: datasheet", "Switch between datasheet and SI units", (self) => {
          state.si = !state.si;
          self.textContent = "units: " + (state.si ? "SI" : "datasheet");
          draw(stage, figure, state);
        })]
      : [];
    const more = [...switches, ...units];
    more.forEach((one) => { one.hidden = true; });
    const open = button("Zoom and read values", "Draw this figure so that it zooms and shows values", (self) => {
      const opening = stage.hidden;
      plotly().then(() => {
        stage.hidden = !opening;
        still.classList.toggle("explore-still", opening);
        more.forEach((one) => { one.hidden = !opening; });
        self.textContent = opening ? "Back to the drawn figure" : "Zoom and read values";
        self.setAttribute("aria-expanded", String(opening));
        return opening ? draw(stage, figure, state) : null;
      }).then(() => { stage.dataset.ready = "yes"; }, () => { self.textContent = "plotly.min.js is not beside this page"; });
    });
    open.setAttribute("aria-expanded", "false");
    bar.append(open, ...more);
    still.before(bar);
    still.before(stage);
  }

  document.addEventListener("DOMContentLoaded", () => document.querySelectorAll("script.explorable").forEach(offer));
})();
