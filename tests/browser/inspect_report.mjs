// Opens a report in headless Chromium, uses it as a reader does and prints what it finds as JSON:
//   node inspect_report.mjs CHROMIUM REPORT [FOLDER FOR PICTURES]
import { readFileSync, mkdirSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [, , executablePath, report, pictures] = process.argv;
const address = pathToFileURL(report).href;
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const views = {
  light: { colorScheme: "light", viewport: { width: 1280, height: 900 } },
  dark: { colorScheme: "dark", viewport: { width: 1280, height: 900 } },
  narrow: { colorScheme: "light", viewport: { width: 400, height: 800 } },
};
// Of one tab, Chromium asks before it takes more than ten; nobody is there to answer.
const MOST_DOWNLOADS = 8;
const found = { violations: {}, wide: {}, requests: [], errors: [], links: [], downloads: [] };

const browser = await chromium.launch({
  executablePath,
  args: [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
  ],
});
for (const [name, view] of Object.entries(views)) {
  // Without motion a link's jump is done at once, however busy the machine is.
  const settings = { acceptDownloads: true, reducedMotion: "reduce" };
  const context = await browser.newContext({ ...view, ...settings });
  const page = await context.newPage();
  page.setDefaultTimeout(120000);
  page.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith("data:") && url.split("#")[0] !== address) found.requests.push(url);
  });
  page.on("console", (message) => {
    if (message.type() === "error") found.errors.push(message.text());
  });
  page.on("pageerror", (error) => found.errors.push(String(error)));
  await page.goto(address, { waitUntil: "load" });
  // The page's policy admits no foreign script: the debugger evaluates axe instead.
  await page.evaluate(axe);
  const outcome = await page.evaluate(() =>
    window.axe.run(document, { resultTypes: ["violations"] }),
  );
  found.violations[name] = outcome.violations.map((violation) => ({
    id: violation.id,
    nodes: violation.nodes.slice(0, 5).map((node) => `${node.target} ${node.failureSummary}`),
  }));
  // How much wider than the window the page is: nobody should have to scroll sideways.
  found.wide[name] = await page.evaluate(
    () => document.documentElement.scrollWidth - window.innerWidth,
  );
  if (pictures) {
    mkdirSync(pictures, { recursive: true });
    await page.screenshot({ path: `${pictures}/${name}.png`, fullPage: true });
  }
  if (name === "light") await use(page);
  await context.close();
}
await browser.close();
console.log(JSON.stringify(found));

// Polled from here: a condition that the page itself would evaluate is against its policy.
async function settled(page, id) {
  let seen = { section: false, contents: false };
  for (let attempt = 0; attempt < 100 && !seen.section; attempt += 1) {
    await page.waitForTimeout(50);
    seen = await page.evaluate((id) => {
      const inView = (box) => box.top < window.innerHeight && box.bottom > 0;
      return {
        section: inView(document.getElementById(id).getBoundingClientRect()),
        contents: inView(document.querySelector("nav.contents").getBoundingClientRect()),
      };
    }, id);
  }
  return seen;
}

async function use(page) {
  await page.keyboard.press("Tab");
  found.first = await page.evaluate(() => document.activeElement.className);
  const targets = await page.$$eval("nav.contents a", (all) => all.map((a) => a.hash));
  for (const hash of targets) {
    await page.focus(`nav.contents a[href="${hash}"]`);
    await page.keyboard.press("Enter");
    found.links.push({ hash, ...(await settled(page, hash.slice(1))) });
  }
  const count = await page.locator("#downloads a[download]").count();
  let tab = page;
  for (let place = 0; place < count; place += 1) {
    if (place > 0 && place % MOST_DOWNLOADS === 0) {
      tab = await page.context().newPage();
      await tab.goto(address, { waitUntil: "load" });
    }
    const [download] = await Promise.all([
      tab.waitForEvent("download"),
      tab.locator("#downloads a[download]").nth(place).click(),
    ]);
    const text = readFileSync(await download.path(), "utf8");
    found.downloads.push({ name: download.suggestedFilename(), text });
  }
  const copies = page.locator("button.copy");
  if (await copies.count()) await copies.first().click();
  found.copied = await page.evaluate(() => window.getSelection().toString());
  await page.locator("#theme").focus();
  await page.keyboard.press("Enter");
  found.theme = await page.evaluate(() => document.documentElement.getAttribute("data-theme"));
  found.named = await page.$$eval("svg.figure", (all) =>
    all.map((svg) => document.getElementById(svg.getAttribute("aria-labelledby")).textContent),
  );
  // Paper is white, whatever the screen shows.
  await page.emulateMedia({ media: "print" });
  found.paper = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  if (pictures) await page.pdf({ path: `${pictures}/print.pdf`, preferCSSPageSize: true });
}
