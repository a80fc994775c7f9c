// `wbqp view`: the page that is built into the program, with a log.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { copyFile, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before, describe, test } from "node:test";
import { browser, field, here, open, pictures, until } from "./help.mjs";
import { built } from "./programs.mjs";

const recorded = here("../../target/web-test/push_with_disturbance.mcap");
let chrome, folder, program;

/** Starts the program; what it prints first is the address. */
async function view(log, ...options) {
  const child = spawn(program, ["view", log, "--no-browser", ...options], { stdio: ["ignore", "pipe", "inherit"] });
  const lines = createInterface({ input: child.stdout });
  const address = await new Promise((done, fail) => {
    lines.once("line", done);
    child.once("exit", (code) => fail(new Error(`it ended with ${code}`)));
  });
  const gone = new Promise((done) => child.once("exit", done));
  return { address, end: () => (child.kill(), gone) };
}

const replayed = (page) => page.waitForFunction(() => document.body.dataset.replay, null, { timeout: 60_000 });
const says = (page, words) =>
  page.waitForFunction(
    (words) => new RegExp(words).test(document.querySelector("#problem:not([hidden])")?.textContent),
    words,
  );

before(async () => {
  program = built().wbqp;
  chrome = await browser();
  folder = await mkdtemp(join(tmpdir(), "wbqp view "));
});
after(async () => {
  await chrome?.close();
  if (folder) await rm(folder, { recursive: true });
});

describe("wbqp view", () => {
  test("shows a log, whatever its name is, and reads it again", async () => {
    const log = join(folder, "a run, 50 % & more #2.mcap");
    await copyFile(recorded, log);
    const { address, end } = await view(log);
    try {
      assert.match(address, /^http:\/\/127\.0\.0\.1:\d+\/\?log=/);
      const { page, errors } = await open(chrome, address);
      await replayed(page);
      assert.equal(await page.evaluate(() => document.body.dataset.replay), "a run, 50 % & more #2.mcap");
      await page.locator("#scrub").evaluate((scrub) => {
        scrub.value = "14";
        scrub.dispatchEvent(new Event("input"));
      });
      const force = -(await field(page, "contact/tip/true"))[0];
      assert.ok(Math.abs(force - 5) < 0.5, `${force}`);
      await page.waitForTimeout(300);
      await page.screenshot({ path: join(pictures, "view.png") });
      assert.deepEqual(errors, []);

      // What is written over it is not what is shown, and is said.
      const bytes = await readFile(log);
      await writeFile(log, bytes.subarray(0, bytes.length / 2));
      await page.click("#reload");
      await says(page, "cannot be read");
      await writeFile(log, "no log");
      await page.click("#reload");
      await says(page, "500: is no MCAP file");
      await rm(log);
      await page.click("#reload");
      await says(page, "answers with 404");
      await page.screenshot({ path: join(pictures, "view-missing.png") });
      assert.ok(Math.abs((await field(page, "time"))[0] - 14) < 0.01);
      await writeFile(log, bytes);
      await page.click("#reload");
      await page.waitForFunction(
        () => document.querySelector("#problem").hidden && !document.querySelector("#reload").disabled,
      );
      assert.ok(Math.abs((await field(page, "time"))[0] - 14) < 0.01);
      await page.click("#play");
      await until(page, 14.5);
      await page.click("#play");

      // Another scenario leaves the log, also in the address; the button goes back.
      await page.selectOption("#scenario", "push_away");
      await page.waitForFunction(() => !document.body.dataset.replay && !location.search);
      await page.click("#reload");
      await replayed(page);
      await page.close();
    } finally {
      await end();
    }
  });

  test("words stand on the page when the program has ended, and what is there stays", async () => {
    const { address, end } = await view(recorded);
    const { page } = await open(chrome, address).catch(async (error) => {
      await end();
      throw error;
    });
    await replayed(page);
    await end();
    await page.click("#reload");
    await says(page, "no connection to 127\\.0\\.0\\.1.*wbqp view");
    await page.screenshot({ path: join(pictures, "view-lost.png") });
    await page.click("#play");
    await until(page, 0.5);
    await page.selectOption("#scenario", "push_away");
    await page.waitForFunction(() => !document.body.dataset.replay);
    await page.click("#edit");
    await says(page, "editor cannot be loaded");
    await page.click("#play");
    await until(page, 0.5);
    await page.close();
  });

  test("what a link names beside the page is fetched, and nothing else", async () => {
    const { address, end } = await view(recorded);
    try {
      const origin = new URL(address).origin;
      const asked = [];
      for (const [query, words] of [
        ["?log=nothing.mcap", "nothing.mcap cannot be fetched.*404: there is nothing of this name"],
        ["?log=https%3A%2F%2Fexample.org%2Fa.mcap", "own host alone"],
        ["?log=http%3A%2F%2F", "is no path"],
        ["?log=index.html", "index.html cannot be read"],
      ]) {
        const page = await chrome.newPage();
        page.on("request", (request) => asked.push(request.url()));
        await page.goto(`${origin}/${query}`);
        await says(page, words);
        // The page goes on behind the words.
        await page.click("#play");
        await until(page, 0.1);
        await page.close();
      }
      assert.deepEqual(
        asked.filter((url) => /^http/.test(url) && !url.startsWith(`${origin}/`)),
        [],
      );
    } finally {
      await end();
    }
  });
});
