// Draws each figure when it comes near the window, and all of them before the page is printed.
(function () {
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

  function draw(place) {
    if (place.dataset.drawn) {
      return;
    }
    place.dataset.drawn = "yes";
    const plot = JSON.parse(place.nextElementSibling.textContent);
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
