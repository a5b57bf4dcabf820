"use strict";
(function () {
  var root = document.documentElement;
  var button = document.getElementById("theme");
  var system = window.matchMedia("(prefers-color-scheme: dark)");
  function dark() {
    var chosen = root.getAttribute("data-theme");
    return chosen ? chosen === "dark" : system.matches;
  }
  function label() {
    button.textContent = dark() ? "Light page" : "Dark page";
  }
  button.hidden = false;
  button.addEventListener("click", function () {
    root.setAttribute("data-theme", dark() ? "light" : "dark");
    label();
  });
  system.addEventListener("change", label);
  label();

  var said = document.getElementById("copied");
  document.querySelectorAll("button.copy").forEach(function (copy) {
    copy.hidden = false;
    copy.addEventListener("click", function () {
      var source = document.getElementById(copy.getAttribute("data-copy"));
      // Selected in any case: where a browser forbids copying, the keyboard still can.
      window.getSelection().selectAllChildren(source);
      var done = function () {
        said.textContent = "Copied.";
      };
      if (navigator.clipboard) {
        navigator.clipboard.writeText(source.textContent).then(done, function () {
          said.textContent = "Selected: copy it with the keyboard.";
        });
      } else if (document.execCommand("copy")) {
        done();
      }
    });
  });

  // What scrolls sideways in a narrow window must be reachable by keyboard.
  function reachable() {
    document.querySelectorAll("figure, .maprow").forEach(function (box) {
      if (box.scrollWidth > box.clientWidth) {
        box.setAttribute("tabindex", "0");
      } else {
        box.removeAttribute("tabindex");
      }
    });
  }
  window.addEventListener("resize", reachable);
  reachable();

  var links = {};
  document.querySelectorAll("nav.contents a").forEach(function (link) {
    links[link.hash.slice(1)] = link;
  });
  function mark(id) {
    Object.keys(links).forEach(function (key) {
      if (key === id) {
        links[key].setAttribute("aria-current", "true");
      } else {
        links[key].removeAttribute("aria-current");
      }
    });
  }
  if ("IntersectionObserver" in window) {
    var observer = new IntersectionObserver(
      function (entries) {
        entries.forEach(function (entry) {
          if (entry.isIntersecting) {
            mark(entry.target.id);
          }
        });
      },
      { rootMargin: "-10% 0px -80% 0px" }
    );
    document.querySelectorAll("main section[id]").forEach(function (section) {
      observer.observe(section);
    });
  }
})();
