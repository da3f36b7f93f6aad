/* What a chapter promised at its head, to be ticked off at its end; the front page counts. Kept by this browser alone. */
(function () {
  "use strict";
  const key = (slug) => "imu_lib book: " + slug;
  const load = (slug) => { try { return JSON.parse(localStorage.getItem(key(slug))) || []; } catch (error) { return []; } };
  const save = (slug, done) => { try { localStorage.setItem(key(slug), JSON.stringify(done)); } catch (error) { /* a browser that keeps nothing */ } };
  const slugOf = (address) => address.split(/[?#]/)[0].split("/").pop().replace(/\.html$/, "");

  // the objectives are one paragraph, parted by dots
  function promised(article) {
    const head = [...article.querySelectorAll("p > strong")].find((one) => one.textContent.trim() === "You will be able to");
    return head ? head.parentElement.textContent.replace("You will be able to", "").trim().replace(/\.$/, "").split(" · ").map((t) => t.trim()) : [];
  }

  function checklist(article) {
    const goals = promised(article);
    const next = [...article.querySelectorAll("p > strong")].find((one) => one.textContent.trim() === "Next");
    if (!goals.length || !next) return;
    const slug = slugOf(location.pathname), done = load(slug);
    const list = document.createElement("div");
    list.className = "can-now";
    list.innerHTML = "<p><strong>Can you now</strong></p>";
    goals.forEach((goal, number) => {
      const label = document.createElement("label"), tick = document.createElement("input");
      tick.type = "checkbox";
      tick.checked = Boolean(done[number]);
      tick.addEventListener("change", () => { done[number] = tick.checked; save(slug, goals.map((_, k) => Boolean(done[k]))); });
      label.append(tick, " " + goal + "?");
      list.append(label);
    });
    next.parentElement.before(list);
  }

  function count() {
    document.querySelectorAll(".chapter-card").forEach((card) => {
      const link = card.querySelector("a[href]");
      const done = link ? load(slugOf(link.getAttribute("href"))) : [];
      if (!done.some(Boolean)) return;
      const said = document.createElement("span");
      said.className = "chapter-done";
      said.textContent = done.every(Boolean) ? "\u2713 done" : done.filter(Boolean).length + " of " + done.length + " goals";
      (card.querySelector(".chapter-time") || card).append(said);
    });
  }

  document.addEventListener("DOMContentLoaded", () => {
    const article = document.querySelector("article.bd-article");
    if (article) checklist(article);
    count();
  });
})();
