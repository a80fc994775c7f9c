// Boxes of words over the view: a few lines, so that the robot is seen, and all of them on request.

export class WordBox {
  private readonly title = document.createElement("strong");
  private readonly text = document.createElement("div");
  private readonly more = document.createElement("button");

  constructor(private readonly host: HTMLElement) {
    this.text.className = "text";
    // What has more than is seen can be scrolled, also with a keyboard.
    this.text.tabIndex = -1;
    this.more.className = "more";
    this.more.type = "button";
    this.more.onclick = () => {
      host.classList.toggle("open");
      this.fit();
    };
    host.replaceChildren(this.title, this.text, this.more);
    new ResizeObserver(() => this.fit()).observe(this.text);
  }

  /** Shows a text; without one, nothing. */
  show(text: string, title = ""): void {
    // What reads it aloud hears what is new alone.
    if (this.text.textContent !== text) this.text.textContent = text;
    if (this.title.textContent !== title) this.title.textContent = title;
    this.title.hidden = title === "";
    this.host.hidden = text === "" && title === "";
    this.fit();
  }

  hide(): void {
    this.show("");
  }

  private fit(): void {
    const isOpen = this.host.classList.contains("open");
    const isCut = this.text.scrollHeight > this.text.clientHeight + 1;
    this.more.hidden = !isOpen && !isCut;
    this.text.tabIndex = isCut ? 0 : -1;
    const label = isOpen ? "Less" : "More";
    if (this.more.textContent !== label) this.more.textContent = label;
    this.more.setAttribute("aria-expanded", String(isOpen));
  }
}
