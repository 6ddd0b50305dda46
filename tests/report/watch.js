// First of all scripts of the page: notes everything that goes wrong.
const wrong = [];
addEventListener("error", (event) => wrong.push(`error: ${event.message}`));
addEventListener("unhandledrejection", (event) => wrong.push(`rejection: ${event.reason}`));
addEventListener("securitypolicyviolation", (event) => wrong.push(`policy: ${event.violatedDirective} ${event.blockedURI}`));
for (const level of ["error", "warn"]) {
  const said = console[level];
  console[level] = (...words) => {
    wrong.push(`console.${level}: ${words.join(" ")}`);
    said.apply(console, words);
  };
}
