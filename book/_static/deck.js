/* A chapter as slides: the page itself, shown piece by piece. No library, no network, formulas and figures as they stand. */
(function () {
  "use strict";
  const HEADS = "h1, h2, h3, h4";
  const BLOCKS = HEADS + ", p, ul, ol, dl, figure, blockquote, div.cell, div.math, div.admonition, div.exercise, div.solution, .pst-scrollable-table-container, table, div.citation-list";
  let slides = null, at = 0;

  // every block of the page that lies in no other block
  function blocks(article) {
    return [...article.querySelectorAll(BLOCKS)].filter((one) => {
      const outer = one.parentElement.closest(BLOCKS);
      return !(outer && article.contains(outer)) && !one.closest(".toctree-wrapper, .prev-next-footer, .can-now");
    });
  }
  const draws = (block) => block.matches("figure, table, .pst-scrollable-table-container, div.exercise") ||
    block.querySelector("figure, table, img, .explore-bar");

  // a slide begins at a heading, with each figure, table or exercise, and where three paragraphs stand already
  function cut(article) {
    const found = [];
    let head = [], slide = null, texts = 0;
    for (const block of blocks(article)) {
      if (block.matches("div.cell") && !block.querySelector(".cell_output")) continue;
      if (block.matches(HEADS)) {
        head = [block];
        slide = null;
        continue;
      }
      const own = draws(block) || block.matches("div.solution");
      if (!slide || own || slide.own || texts >= 3) {
        slide = { blocks: [...head], own };
        found.push(slide);
        texts = 0;
      }
      texts += 1;
      slide.blocks.push(block);
    }
    return found;
  }

  function show(number) {
    at = Math.max(0, Math.min(number, slides.length - 1));
    const now = new Set(slides[at].blocks);
    document.querySelectorAll(".deck-block").forEach((block) => block.classList.toggle("deck-now", now.has(block)));
    document.querySelector(".deck-count").textContent = at + 1 + " / " + slides.length;
    window.scrollTo(0, 0);
    window.dispatchEvent(new Event("resize"));
  }

  function start() {
    const article = document.querySelector("article.bd-article");
    if (!article) return;
    if (!slides) {
      slides = cut(article);
      blocks(article).forEach((block) => block.classList.add("deck-block"));
      const bar = document.createElement("div");
      bar.className = "deck-bar";
      bar.innerHTML = '<button type="button">\u2190</button><span class="deck-count"></span><button type="button">\u2192</button>' +
        '<button type="button">code</button><button type="button">end</button>';
      const acts = [() => show(at - 1), () => show(at + 1), () => document.body.classList.toggle("deck-code"), stop];
      bar.querySelectorAll("button").forEach((button, k) => button.addEventListener("click", acts[k]));
      document.body.append(bar);
    }
    document.body.classList.add("deck");
    show(at);
  }

  function stop() {
    document.body.classList.remove("deck", "deck-code");
  }

  document.addEventListener("keydown", (event) => {
    if (!document.body.classList.contains("deck") || event.ctrlKey || event.metaKey || event.altKey) return;
    const act = { ArrowRight: () => show(at + 1), PageDown: () => show(at + 1), " ": () => show(at + 1), ArrowLeft: () => show(at - 1),
      PageUp: () => show(at - 1), Home: () => show(0), End: () => show(slides.length - 1), Escape: stop,
      c: () => document.body.classList.toggle("deck-code") }[event.key];
    if (act && !(event.target.closest && event.target.closest("input, textarea"))) {
      event.preventDefault();
      event.stopPropagation();
      act();
    }
  }, true);

  document.addEventListener("DOMContentLoaded", () => {
    const article = document.querySelector("article.bd-article");
    const buttons = document.querySelector(".article-header-buttons") || document.querySelector(".header-article-items__end");
    if (!article || !buttons || !article.querySelector("div.cell")) return;
    const button = document.createElement("button");
    button.type = "button";
    button.className = "btn btn-sm deck-start";
    button.title = "Show this chapter as slides (arrow keys; c for the code; Esc ends)";
    button.textContent = "Slides";
    button.addEventListener("click", start);
    buttons.prepend(button);
    if (location.hash === "#slides") start();
  });
})();
