import "./style.css";
import { mount } from "svelte";
import App from "./App.svelte";

mount(App, { target: document.body });

// Without a network the page works from the browser's storage. The development server stores nothing.
if (import.meta.env.PROD && "serviceWorker" in navigator) {
    addEventListener("load", () => void navigator.serviceWorker.register("./service-worker.js").catch(() => undefined));
}
