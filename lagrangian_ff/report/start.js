// Unpacks plotly.js and the figures' data once the page is painted, draws each figure when it comes
// near the window, and all of them before the page is printed.
(async function () {
  "use strict";
  const config = {
    displaylogo: false,
    responsive: true,
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  };
  const hovers = window.matchMedia("(hover: hover)").matches;
  if (!hovers) {
    config.displayModeBar = false;
  }
  const places = Array.from(document.querySelectorAll(".plot"));
  if (!("DecompressionStream" in window)) {
    for (const place of places) {
      place.textContent = "This browser is too old to draw: " + place.getAttribute("aria-label");
    }
    return;
  }

  function unpacked(element) {
    const bytes = Uint8Array.from(atob(element.textContent), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

  await new Promise((painted) => requestAnimationFrame(() => setTimeout(painted)));
  const texts = new Map();
  const [code] = await Promise.all([
    unpacked(document.getElementById("library")),
    ...places.map(async (place) => texts.set(place, await unpacked(place.nextElementSibling))),
  ]);
  const library = document.createElement("script");
  library.textContent = code;
  document.body.append(library);

  function draw(place) {
    if (place.dataset.drawn) {
      return;
    }
    place.dataset.drawn = "yes";
    const plot = JSON.parse(texts.get(place));
    if (!hovers) {
      plot.layout.dragmode = false; // a finger on a figure scrolls the page
    }
    Plotly.newPlot(place, plot.data, plot.layout, config);
  }

  const watch = new IntersectionObserver(
    function (entries) {
      for (const entry of entries) {
        if (entry.isIntersecting) {
          watch.unobserve(entry.target);
          draw(entry.target);
        }
      }
    },
    { rootMargin: "600px" },
  );
  places.forEach((place) => watch.observe(place));

  window.addEventListener("beforeprint", function () {
    document.body.classList.add("printing");
    places.forEach(draw);
    places.forEach((place) => Plotly.Plots.resize(place));
  });
  window.addEventListener("afterprint", function () {
    document.body.classList.remove("printing");
  });
})();
