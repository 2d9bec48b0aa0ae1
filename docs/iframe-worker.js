// A browser starts no worker from a file. There, the worker of the search runs in a hidden frame instead.
if (location.protocol === "file:") {
  class FrameWorker extends EventTarget {
    constructor(address) {
      super();
      this.waiting = [];
      const frame = document.createElement("iframe");
      frame.hidden = true;
      frame.srcdoc =
        "<script>" +
        "postMessage = (data) => frameElement.deliver(data);" +
        "importScripts = (...all) => all.reduce((before, one) => before.then(() => new Promise((done, failed) => {" +
        "  const script = Object.assign(document.createElement('script'), { src: one, onload: done, onerror: failed });" +
        "  document.body.append(script);" +
        "})), Promise.resolve());" +
        "</script><body><script src=\"" + new URL(address, location.href) + "\"></script></body>";
      frame.deliver = (data) => {
        const event = new MessageEvent("message", { data });
        this.dispatchEvent(event);
        this.onmessage?.(event);
      };
      frame.onload = () => {
        this.frame = frame;
        for (const data of this.waiting.splice(0)) this.postMessage(data);
      };
      document.body.append(frame);
    }

    postMessage(data) {
      if (this.frame === undefined) this.waiting.push(data);
      else this.frame.contentWindow.dispatchEvent(new this.frame.contentWindow.MessageEvent("message", { data }));
    }

    terminate() {
      this.frame?.remove();
    }
  }
  window.IFrameWorker = window.Worker = FrameWorker; // the first name is how the theme's worker knows where it is
}
