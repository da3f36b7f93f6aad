/* Computed tables: a click on a heading sorts, a button saves the table as CSV. Printed sentences wrap.
   No library, no network. */
(function () {
  "use strict";
  // a page opened from a disk may not fetch others: the search lists titles and headings without excerpts
  if (location.protocol === "file:" && typeof DOCUMENTATION_OPTIONS !== "undefined") {
    DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
  }
  const value = (text) => {
    const found = text.replace(/[−–]/g, "-").match(/-?\d+(\.\d+)?(e[+-]?\d+)?/i);
    return found ? parseFloat(found[0]) : NaN;
  };
  function sort(table, column, heading) {
    const body = table.tBodies[0];
    const down = heading.getAttribute("aria-sort") === "ascending";
    table.querySelectorAll("th[aria-sort]").forEach((th) => th.removeAttribute("aria-sort"));
    heading.setAttribute("aria-sort", down ? "descending" : "ascending");
    const rows = [...body.rows].map((row) => [row.cells[column].innerText.trim(), row]);
    const numbers = rows.every(([text]) => text === "" || text === "-" || !isNaN(value(text)));
    rows.sort(([a], [b]) => {
      const order = numbers ? (value(a) || 0) - (value(b) || 0) : a.localeCompare(b, "en", { numeric: true });
      return down ? -order : order;
    });
    rows.forEach(([, row]) => body.appendChild(row));
  }
  function save(table, name) {
    const quoted = (cell) => '"' + cell.innerText.trim().replace(/"/g, '""') + '"';
    const text = [...table.rows].map((row) => [...row.cells].map(quoted).join(",")).join("\r\n");
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob(["\ufeff" + text], { type: "text/csv" }));
    link.download = name + ".csv";
    link.click();
    URL.revokeObjectURL(link.href);
  }
  // sentences that a cell printed wrap; what stands in columns keeps them and scrolls
  function wrap(pre) {
    const lines = pre.textContent.split("\n").filter((line) => line.trim());
    const columns = lines.filter((line) => /\S {2,}\S/.test(line.trim())).length;
    pre.classList.toggle("wraps", 2 * columns <= lines.length);
  }
  // a drawing of several panels is marked: on a phone it keeps its size and is swiped
  function mark(img) {
    const wide = () => {
      img.classList.toggle("panels", img.naturalWidth > 700);
      (img.closest(".output") || img.parentElement).classList.toggle("swiped", img.naturalWidth > 700);
    };
    if (img.complete) wide();
    else img.addEventListener("load", wide);
  }
  document.addEventListener("DOMContentLoaded", () => {
    document.querySelectorAll(".cell_output pre").forEach(wrap);
    document.querySelectorAll(".cell_output img").forEach(mark);
    document.querySelectorAll("table.computed").forEach((table, number) => {
      const heads = table.tHead ? table.tHead.rows : [];
      if (heads.length) {
        [...heads[heads.length - 1].cells].forEach((th, column) => {
          th.tabIndex = 0;
          th.title = "Sort by this column";
          const act = () => sort(table, column, th);
          th.addEventListener("click", act);
          th.addEventListener("keydown", (event) => { if (event.key === "Enter") act(); });
        });
      }
      const button = document.createElement("button");
      button.type = "button";
      button.className = "save-table";
      button.textContent = "CSV";
      button.title = "Save this table as CSV";
      const page = location.pathname.split("/").pop().replace(/\.html$/, "") || "table";
      button.addEventListener("click", () => save(table, page + "_table_" + (number + 1)));
      (table.caption || table.parentElement).appendChild(button);
    });
  });
})();
