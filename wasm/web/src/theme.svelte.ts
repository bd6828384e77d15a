// Dark or light: the system's choice, or the reader's own, which is kept.

export type Theme = "system" | "light" | "dark";

const KEY = "narx.theme";
const system = matchMedia("(prefers-color-scheme: dark)");

let chosen = $state<Theme>(stored());
let systemIsDark = $state(system.matches);
system.addEventListener("change", () => {
    systemIsDark = system.matches;
});
apply();

/** What the reader chose. */
export function theme(): Theme {
    return chosen;
}

/** Whether it is dark now: pictures that are drawn on a canvas depend on it. */
export function isDark(): boolean {
    return chosen === "system" ? systemIsDark : chosen === "dark";
}

export function choose(theme: Theme): void {
    chosen = theme;
    apply();
    try {
        localStorage.setItem(KEY, theme);
    } catch {
        // A browser that keeps nothing: until the page is closed, then.
    }
}

/** A colour of style.css as a canvas wants it. */
export function colour(name: string): string {
    const probe = document.createElement("i");
    probe.style.color = `var(${name})`;
    document.body.append(probe);
    const { color } = getComputedStyle(probe);
    probe.remove();
    return color;
}

function stored(): Theme {
    try {
        const theme = localStorage.getItem(KEY);
        return theme === "light" || theme === "dark" ? theme : "system";
    } catch {
        return "system";
    }
}

function apply(): void {
    document.documentElement.dataset.theme = chosen;
}
