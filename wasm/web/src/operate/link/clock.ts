// Ticks from a worker: a browser slows the page's own timers down when the page is hidden, and a drive that hears no set-point stops.

addEventListener("message", ({ data: period }: MessageEvent<number>) => {
    setInterval(() => postMessage(undefined), period);
});
