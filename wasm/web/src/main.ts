import "./style.css";
import { mount } from "svelte";
import App from "./App.svelte";

mount(App, { target: document.body });

// Without a network the page works from what the browser keeps. While it is developed nothing is kept.
if (import.meta.env.PROD && "serviceWorker" in navigator) {
    addEventListener("load", () => void navigator.serviceWorker.register("./service-worker.js").catch(() => undefined));
}
