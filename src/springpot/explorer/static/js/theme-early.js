// before the first paint: a theme that was chosen, or that of the system
(() => {
  let chosen = null;
  try { chosen = localStorage.getItem("springpot-theme"); } catch { /* storage may be forbidden */ }
  if (chosen === "dark" || chosen === "light") document.documentElement.dataset.theme = chosen;
})();
