// Address within the page: `#/AREA/PAGE?QUERY`. It is in the hash, because a server of static files knows
// only the page itself.

export interface Route {
    area: string;
    page: string;
    query: URLSearchParams;
}

/** Parses a hash; missing parts are empty. */
export function parse(hash: string): Route {
    const [path = "", query = ""] = hash.replace(/^#\/?/, "").split("?", 2);
    const [area = "", page = ""] = path.split("/");
    return { area: area || "learn", page, query: new URLSearchParams(query) };
}

let current = $state.raw(parse(location.hash));
addEventListener("hashchange", () => {
    current = parse(location.hash);
});

/** Returns the present route. */
export function route(): Route {
    return current;
}
