// Opens a report in headless Chromium and prints what it finds as JSON.
//   node inspect_report.mjs CHROMIUM REPORT [FOLDER FOR PICTURES]
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [, , executablePath, report, pictures] = process.argv;
const address = pathToFileURL(report).href;
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const found = { violations: {}, requests: [], links: [], downloads: [], errors: [], copied: false };

const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--disable-gpu"] });
for (const colorScheme of ["light", "dark"]) {
  const context = await browser.newContext({
    colorScheme,
    viewport: { width: 1280, height: 900 },
    acceptDownloads: true,
  });
  const page = await context.newPage();
  page.setDefaultTimeout(120000);
  page.on("request", (request) => {
    const url = request.url();
    if (url !== address && !url.startsWith("data:") && !url.startsWith(address + "#")) {
      found.requests.push(url);
    }
  });
  page.on("console", (message) => {
    if (message.type() === "error") found.errors.push(message.text());
  });
  page.on("pageerror", (error) => found.errors.push(String(error)));
  await page.goto(address, { waitUntil: "load" });
  // The page's policy admits no foreign script: axe is evaluated by the debugger instead.
  await page.evaluate(axe);
  const outcome = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  found.violations[colorScheme] = outcome.violations.map((violation) => ({
    id: violation.id,
    nodes: violation.nodes.slice(0, 5).map((node) => `${node.target} ${node.failureSummary}`),
  }));
  if (pictures) {
    await page.screenshot({ path: `${pictures}/${colorScheme}.png`, fullPage: true });
  }
  if (colorScheme === "light") {
    const targets = await page.$$eval("nav.contents a", (all) => all.map((a) => a.hash));
    for (const hash of targets) {
      await page.click(`nav.contents a[href="${hash}"]`);
      await page.waitForFunction((id) => {
        const box = document.getElementById(id).getBoundingClientRect();
        return box.top < window.innerHeight && box.bottom > 0;
      }, hash.slice(1));
      found.links.push(hash);
    }
    const link = page.locator("#downloads a[download]").first();
    const [download] = await Promise.all([page.waitForEvent("download"), link.click()]);
    const text = readFileSync(await download.path(), "utf8");
    found.downloads.push({ name: download.suggestedFilename(), text });
    await page.locator("button.copy").first().click();
    found.copied = await page.evaluate(
      () => window.getSelection().toString().length > 20
    );
    await page.locator("#theme").focus();
    await page.keyboard.press("Enter");
    found.theme = await page.evaluate(() => document.documentElement.getAttribute("data-theme"));
    if (pictures) await page.pdf({ path: `${pictures}/print.pdf` });
  }
  await context.close();
}
await browser.close();
console.log(JSON.stringify(found));
