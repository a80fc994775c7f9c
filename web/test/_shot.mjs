import { browser, open, serve, until } from "/tmp/web16/web/test/help.mjs";
const host = await serve(); const b = await browser();
const [,, hash, time, out, w, h, full] = process.argv;
const { page, errors } = await open(b, host.address + hash, { width: Number(w||1400), height: Number(h||900) });
await page.click("#play"); await until(page, Number(time), 120000); await page.click("#play"); await page.waitForTimeout(400);
await page.screenshot({ path: out, fullPage: !!full });
console.log("errors", errors, await page.textContent("#pace"), await page.textContent("#tick"), await page.textContent("#problem"));
await b.close(); host.close();
