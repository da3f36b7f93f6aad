/* Words of the glossary explain themselves: the first of each on a page, on hover, focus or touch. No library, no network. */
(function () {
  "use strict";
  const SKIP = "a, code, pre, h1, h2, h3, h4, h5, button, summary, math, mjx-container, script, style, table, dt, .math, .caption-number, .term";
  const BLOCKS = "p, li, figcaption, dd";

  // a word as it may stand in a sentence: any case, a plural s, hyphen or blank
  const pattern = (word) => word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&").replace(/[ -]/g, "[\\s-]+");

  function texts(article) {
    const walker = document.createTreeWalker(article, NodeFilter.SHOW_TEXT, (node) =>
      node.parentElement.closest(BLOCKS) && !node.parentElement.closest(SKIP) ? NodeFilter.FILTER_ACCEPT : NodeFilter.FILTER_REJECT);
    const found = [];
    while (walker.nextNode()) found.push(walker.currentNode);
    return found;
  }

  // marks the word in the node; returns the text behind it
  function explain(node, at, length, meaning, glossary, word) {
    const rest = node.splitText(at);
    const after = rest.splitText(length);
    const mark = document.createElement(glossary ? "a" : "span");
    mark.className = "term";
    mark.tabIndex = 0;
    mark.textContent = rest.textContent;
    mark.dataset.meaning = meaning;
    if (glossary) mark.href = glossary + "#term-" + word.replace(/ /g, "-");
    rest.replaceWith(mark);
    return after;
  }

  // the box is one for the page, placed inside the window
  function box() {
    const note = document.createElement("div");
    note.className = "term-note";
    note.setAttribute("role", "tooltip");
    note.id = "term-note";
    document.body.append(note);
    const show = (mark) => {
      note.textContent = mark.dataset.meaning;
      note.classList.add("shown");
      mark.setAttribute("aria-describedby", "term-note");
      const place = mark.getBoundingClientRect(), own = note.getBoundingClientRect();
      const left = Math.min(Math.max(8, place.left), document.documentElement.clientWidth - own.width - 8);
      const above = place.top - own.height - 6;
      note.style.left = left + "px";
      note.style.top = (above > 60 ? above : place.bottom + 6) + "px";
    };
    const hide = () => note.classList.remove("shown");
    document.addEventListener("mouseover", (event) => {
      const mark = event.target.closest && event.target.closest(".term");
      if (mark) show(mark);
      else hide();
    });
    document.addEventListener("focusin", (event) => (event.target.matches(".term") ? show(event.target) : hide()));
    document.addEventListener("scroll", () => {  // a word that has the focus keeps its note
      const now = document.activeElement;
      if (now && now.matches(".term")) show(now);
      else hide();
    }, { passive: true });
    document.addEventListener("keydown", (event) => { if (event.key === "Escape") hide(); });
  }

  document.addEventListener("DOMContentLoaded", () => {
    const article = document.querySelector("article.bd-article");
    const words = window.BOOK_TERMS;
    if (!article || !words || document.querySelector("dl.glossary")) return;
    const link = document.querySelector('.bd-sidebar-primary a[href*="glossary.html"]');
    const glossary = link && link.getAttribute("href").split("#")[0];
    const longest = Object.keys(words).sort((a, b) => b.length - a.length);
    const nodes = texts(article);
    for (const word of longest) {
      const any = word === word.toUpperCase() ? "" : "i";  // SURE is not sure
      const search = new RegExp("(?<![\\w-])" + pattern(word) + "s?(?![\\w-])", any);
      for (let place = 0; place < nodes.length; place++) {
        const hit = search.exec(nodes[place].data);
        if (!hit) continue;
        const after = explain(nodes[place], hit.index, hit[0].length, words[word], glossary, word);
        nodes.splice(place + 1, 0, after);
        break;
      }
    }
    box();
  });
})();
