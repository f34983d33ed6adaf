// A service worker: the page opens also where the network is gone. The network comes first, so nobody sees an old page while
// there is a newer one. Files of a page carry its build in their addresses: a page never gets files of another build.
const [BUILD, FILES] = ["__BUILD__", "__FILES__"];

addEventListener("install", (event) => {
    skipWaiting();
    event.waitUntil(caches.open(BUILD).then((cache) => cache.addAll(FILES.split(" ").map((file) => new Request(file, { cache: "reload" })))));
});

addEventListener("activate", (event) => {
    const old = caches.keys().then((names) => Promise.all(names.filter((name) => name !== BUILD).map((name) => caches.delete(name))));
    event.waitUntil(old.then(() => clients.claim()));
});

async function answer(request) {
    try {
        const found = await fetch(request);
        // Libraries for FMUs are large: they are kept once they were asked for.
        if (found.ok && request.url.includes("/binaries")) await (await caches.open(BUILD)).put(request, found.clone());
        return found;
    } catch (error) {
        const kept = await caches.match(request, { ignoreSearch: request.mode === "navigate" });
        if (kept) return kept;
        throw error;
    }
}

addEventListener("fetch", (event) => {
    if (event.request.method === "GET" && new URL(event.request.url).origin === location.origin) event.respondWith(answer(event.request));
});
