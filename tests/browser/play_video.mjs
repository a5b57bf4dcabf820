// Plays a video in headless Chromium, and prints as JSON how it went, with some of its frames:
//   node play_video.mjs CHROMIUM VIDEO SECONDS...
import { readFileSync } from "node:fs";
import { chromium } from "playwright-core";

const [, , executablePath, video, ...times] = process.argv;
const browser = await chromium.launch({
  executablePath,
  args: ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"],
});
const page = await browser.newPage();
page.setDefaultTimeout(120000);
const source = `data:video/webm;base64,${readFileSync(video).toString("base64")}`;
const found = await page.evaluate(
  async ({ source, times }) => {
    const shown = document.createElement("video");
    shown.muted = true;
    document.body.append(shown);
    const happens = (name) =>
      new Promise((resolve, reject) => {
        shown.addEventListener(name, resolve, { once: true });
        shown.addEventListener("error", () => reject(new Error(shown.error.message)), {
          once: true,
        });
      });
    const loaded = happens("loadeddata");
    shown.src = source;
    await loaded;
    const { duration, videoWidth: width, videoHeight: height } = shown;
    const ended = happens("ended");
    await shown.play();
    await ended;
    const played = shown.getVideoPlaybackQuality().totalVideoFrames;
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { width, height });
    const frames = [];
    for (const time of times) {
      const sought = happens("seeked");
      shown.currentTime = time;
      await sought;
      canvas.getContext("2d").drawImage(shown, 0, 0);
      frames.push(canvas.toDataURL("image/png").split(",")[1]);
    }
    return { duration, width, height, played, frames };
  },
  { source, times: times.map(Number) },
);
await browser.close();
console.log(JSON.stringify(found));
