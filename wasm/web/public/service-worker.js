// Keeps the page for use without a network: every file of this version once, and the newest page as long as
// there is a network.

const CACHE = "narx";

addEventListener("install", (event) => event.waitUntil(fill().then(() => skipWaiting())));
addEventListener("activate", (event) => event.waitUntil(clients.claim()));
addEventListener("fetch", (event) => {
    const { method, url } = event.request;
    if (method === "GET" && url.startsWith(registration.scope)) {
        event.respondWith(answer(event.request));
    }
});

/** Stores the files that files.json names, and removes all others. */
async function fill() {
    const names = await (await fetch("./files.json", { cache: "no-store" })).json();
    const cache = await caches.open(CACHE);
    const wanted = ["./", ...names].map((name) => new URL(name, registration.scope).href);
    for (const kept of await cache.keys()) {
        if (!wanted.includes(kept.url)) {
            await cache.delete(kept);
        }
    }
    await cache.addAll(wanted);
}

/** Answers from the network; without one, from the stored files. Files in `assets` never change, because
 * their names contain the digest of their content. */
async function answer(request) {
    const cache = await caches.open(CACHE);
    const kept = await cache.match(request, { ignoreSearch: true });
    if (kept && request.url.includes("/assets/")) {
        return kept;
    }
    return fetch(request).catch((error) => kept ?? Promise.reject(error));
}
