// Ticks from a worker. A browser slows the page's own timers down when the page is hidden, and a drive
// without set-points stops.

addEventListener("message", ({ data: period }: MessageEvent<number>) => {
    setInterval(() => postMessage(undefined), period);
});
