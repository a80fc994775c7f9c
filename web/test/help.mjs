// A plain file server, and a browser that looks at what it serves.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { existsSync, mkdirSync } from "node:fs";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const dist = here("../dist");
export const pictures = here("../test-results");
mkdirSync(pictures, { recursive: true });

const TYPES = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".css": "text/css",
  ".wasm": "application/wasm",
  ".svg": "image/svg+xml",
};

/** Serves the built page below a folder's name, without any header but the type. */
export async function serve() {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://x").pathname)).replace(
      /^\/some\/folder/,
      "",
    );
    const file = join(dist, path === "/" || path === "" ? "index.html" : path);
    try {
      const bytes = await readFile(file);
      response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
      response.end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { address: `http://127.0.0.1:${server.address().port}/some/folder/`, close: () => server.close() };
}

const known = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
export const executablePath = known.find((path) => path && existsSync(path));

export async function browser() {
  if (!executablePath) throw new Error("no browser: install chromium, or name one in CHROMIUM");
  return chromium.launch({
    executablePath,
    args: [
      "--no-sandbox",
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--ignore-gpu-blocklist",
    ],
  });
}

/** A page, with everything that its console calls an error. */
export async function open(browser, address, size = { width: 1400, height: 900 }) {
  const page = await browser.newPage({ viewport: size });
  // Without a graphics card, and beside other programs, a picture takes its time.
  page.setDefaultTimeout(120_000);
  const errors = [];
  page.on("console", (message) => {
    if (message.type() === "error") errors.push(message.text());
  });
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(address);
  await page.waitForFunction(() => document.body.dataset.loaded, null, { timeout: 60_000 });
  return { page, errors };
}

export const field = (page, name) => page.evaluate((name) => window.wbqp.field(name), name);

/** Waits until the simulated time is reached. */
export async function until(page, time, timeout = 60_000) {
  await page.waitForFunction((time) => (window.wbqp.field("time")?.[0] ?? 0) >= time, time, { timeout, polling: 50 });
}
