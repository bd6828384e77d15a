// The address within the page: `#/AREA/PAGE?QUERY`. A static folder has no other that any server would answer.

export interface Route {
    area: string;
    page: string;
    query: URLSearchParams;
}

/** The route that a hash names; what is missing is empty. */
export function parse(hash: string): Route {
    const [path = "", query = ""] = hash.replace(/^#\/?/, "").split("?", 2);
    const [area = "", page = ""] = path.split("/");
    return { area: area || "learn", page, query: new URLSearchParams(query) };
}

let current = $state.raw(parse(location.hash));
addEventListener("hashchange", () => {
    current = parse(location.hash);
});

/** Where the reader is. */
export function route(): Route {
    return current;
}
