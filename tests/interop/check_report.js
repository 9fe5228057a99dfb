// Opens reports in Chromium, without a network, on screens of several widths and as printed on A4, and checks what a reader
// would see.
//
//     NODE_PATH=$(tests/interop/node_environment.sh) node tests/interop/check_report.js FOLDER REPORT.html...
//
// Screenshots and a PDF of every report go to FOLDER. Chromium is the program in the environment variable CHROMIUM or
// `chromium`, as Debian packages it.
"use strict";

const { execFileSync } = require("node:child_process");
const fs = require("node:fs");
const path = require("node:path");
const { pathToFileURL } = require("node:url");
const { chromium } = require("playwright-core");

const [folder, ...reports] = process.argv.slice(2);
// A4 less the margins of the style, in CSS pixels of 1/96 inch.
const MM = 96 / 25.4;
const PAGE = { width: Math.floor((210 - 2 * 15) * MM), height: Math.floor((297 - 12 - 15) * MM) };
const SCREENS = [
  { name: "desktop", width: 1280, height: 800 },
  { name: "phone", width: 412, height: 900 },
];

function program() {
  return process.env.CHROMIUM || execFileSync("which", ["chromium"], { encoding: "utf8" }).trim();
}

// Runs in the page: every fault of the layout at its present width.
function faultsOfLayout({ pageHeight }) {
  const faults = [];
  const width = document.documentElement.clientWidth;
  const named = (element) => `<${element.tagName.toLowerCase()}> "${element.textContent.trim().slice(0, 40)}"`;
  if (document.documentElement.scrollWidth > width) {
    faults.push(`the page is ${document.documentElement.scrollWidth} px wide in a window of ${width} px`);
  }
  for (const element of document.querySelectorAll("main *:not(svg):not(svg *)")) {
    const box = element.getBoundingClientRect();
    if (box.right > width + 0.5 || box.left < -0.5) {
      faults.push(`${named(element)} reaches from ${box.left} to ${box.right} px in a window of ${width} px`);
    }
    if (element.scrollWidth > element.clientWidth + 1 && element.clientWidth > 0) {
      faults.push(`${named(element)} is clipped: ${element.scrollWidth} px in ${element.clientWidth} px`);
    }
  }
  for (const figure of document.querySelectorAll("figure")) {
    const svg = figure.querySelector("svg");
    const box = svg.getBoundingClientRect();
    const caption = figure.querySelector("figcaption").textContent;
    // These take the room that their page has.
    const least = figure.matches(".sketch, .shape, .second-opinion figure") ? 0.2 : 0.5;
    if (box.width < 0.9 * figure.clientWidth || box.height < least * box.width) {
      faults.push(`"${caption}" is shown with ${box.width} x ${box.height} px`);
    }
    if (getComputedStyle(figure).breakInside !== "avoid") {
      faults.push(`"${caption}" may be cut by a page break`);
    }
    if (pageHeight && figure.getBoundingClientRect().height > pageHeight) {
      faults.push(`"${caption}" is higher than a page`);
    }
    if (svg.querySelectorAll("polyline, polygon, path, line").length < 5) {
      faults.push(`"${caption}" is empty`);
    }
    for (const text of svg.querySelectorAll("text")) {
      const inner = text.getBoundingClientRect();
      const tolerance = 0.004 * box.width;
      if (
        inner.left < box.left - tolerance || inner.right > box.right + tolerance ||
        inner.top < box.top - tolerance || inner.bottom > box.bottom + tolerance
      ) {
        faults.push(`"${text.textContent}" leaves the figure "${caption}"`);
      }
    }
  }
  for (const sheet of document.querySelectorAll(".sheet")) {
    if (pageHeight && sheet.scrollHeight > pageHeight) {
      faults.push(`a sheet is ${sheet.scrollHeight} px high, the page ${pageHeight} px: ${named(sheet)}`);
    }
  }
  return faults;
}

// Runs in the page: what is wrong with the document itself.
function faultsOfDocument() {
  const faults = [];
  const outside = document.querySelectorAll("script, link, iframe, img, object, embed, [src], [style*='url']");
  for (const element of outside) {
    faults.push(`<${element.tagName.toLowerCase()}> may load something`);
  }
  const ids = [...document.querySelectorAll("[id]")].map((element) => element.id);
  for (const id of ids.filter((one, place) => ids.indexOf(one) !== place)) {
    faults.push(`the id ${id} is used twice`);
  }
  for (const link of document.querySelectorAll("a[href]")) {
    if (!link.hash || !document.getElementById(decodeURIComponent(link.hash.slice(1)))) {
      faults.push(`the link to ${link.getAttribute("href")} leads nowhere`);
    }
  }
  const first = document.querySelector("main").innerText.trim().split("\n")[0];
  const headline = document.querySelector(".verdict .headline");
  if (!headline || headline.innerText.split("\n")[0] !== first) {
    faults.push(`the first line is not a verdict but "${first}"`);
  } else if (headline.getBoundingClientRect().bottom > window.innerHeight) {
    faults.push("the verdict is visible only after scrolling");
  }
  if (!document.title || !document.documentElement.lang) {
    faults.push("the document has no title or language");
  }
  return faults;
}

async function check(browser, report) {
  const faults = [];
  const found = (where, texts) => texts.forEach((text) => faults.push(`${where}: ${text}`));
  const name = path.basename(report, ".html");
  const address = pathToFileURL(path.resolve(report)).href;
  for (const { name: screen, width, height } of SCREENS) {
    const context = await browser.newContext({ viewport: { width, height }, offline: true });
    const page = await context.newPage();
    page.on("request", (request) => {
      if (request.url() !== address) {
        faults.push(`${screen}: a request to ${request.url()}`);
      }
    });
    page.on("console", (message) => faults.push(`${screen}: the console says "${message.text()}"`));
    page.on("pageerror", (error) => faults.push(`${screen}: ${error}`));
    await page.goto(address, { waitUntil: "load" });
    found(screen, await page.evaluate(faultsOfDocument));
    found(screen, await page.evaluate(faultsOfLayout, {}));
    await page.screenshot({ path: path.join(folder, `${name}_${screen}.png`) });
    await page.screenshot({ path: path.join(folder, `${name}_${screen}_full.png`), fullPage: true });
    if (screen === "desktop") {
      await page.emulateMedia({ media: "print" });
      await page.setViewportSize(PAGE);
      found("print", await page.evaluate(faultsOfLayout, { pageHeight: PAGE.height }));
      const pdf = await page.pdf({ path: path.join(folder, `${name}.pdf`), preferCSSPageSize: true, printBackground: true });
      const text = pdf.toString("latin1");
      const sheets = [...text.matchAll(/\/MediaBox\s*\[\s*0 0 ([\d.]+) ([\d.]+)\s*\]/g)];
      const isA4 = ([, x, y]) => Math.abs(x - 595) < 2 && Math.abs(y - 842) < 2;
      if (sheets.length === 0 || !sheets.every(isA4)) {
        found("print", [`${sheets.length} sheets, not all of them A4: ${sheets[0]}`]);
      }
      console.log(`${name}: ${sheets.length} sheets of A4, ${await page.locator("figure").count()} figures`);
    }
    await context.close();
  }
  return faults.map((fault) => `${name}: ${fault}`);
}

async function main() {
  fs.mkdirSync(folder, { recursive: true });
  const browser = await chromium.launch({
    executablePath: program(),
    // Chromium's sandbox does not run as root; the files are our own.
    chromiumSandbox: process.getuid() !== 0,
  });
  console.log(`Chromium ${browser.version()}`);
  const faults = [];
  for (const report of reports) {
    faults.push(...(await check(browser, report)));
  }
  await browser.close();
  faults.slice(0, 40).forEach((fault) => console.error(fault));
  if (faults.length > 0 || reports.length === 0) {
    console.error(`${faults.length} faults in ${reports.length} reports`);
    process.exit(1);
  }
}

main();
