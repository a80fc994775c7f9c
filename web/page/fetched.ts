// A log that the page's address names, `?log=<path>`: fetched from where the page is from.

export interface Named {
  url: URL;
  /** Without folders. */
  name: string;
}

/** The log that an address names, if it names one; throws if the page does not fetch it. */
export function namedLog(address: string): Named | null {
  const page = new URL(address);
  const path = page.searchParams.get("log");
  if (!path) return null;
  const refuse = (why: string) => new Error(`The address has \`log=${path}\`, ${why}.`);
  if (!URL.canParse(path, page)) throw refuse("which is no path");
  const url = new URL(path, page);
  // A link from somebody else must not make this page ask a third one.
  if (url.origin !== page.origin) throw refuse("but logs are fetched from the page's own host alone");
  const last = url.pathname.split("/").at(-1) ?? "";
  return { url, name: decoded(last) || path };
}

function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/** The log as it is now; throws why it cannot be had, in words. */
export async function fetchLog({ url, name }: Named): Promise<File> {
  const lost = `There is no connection to ${url.host}. Does what serves this page, such as \`wbqp view\`, still run?`;
  const answer = await fetch(url, { cache: "no-store" }).catch(() => {
    throw new Error(lost);
  });
  if (!answer.ok) {
    // What is no plain text is a host's page about the error.
    const isPlain = answer.headers.get("content-type")?.startsWith("text/plain");
    const why = isPlain ? (await answer.text().catch(() => "")).trim() : "";
    throw new Error(`${url.host} answers with ${answer.status}${why ? `: ${why}` : ` ${answer.statusText}`}`);
  }
  const bytes = await answer.arrayBuffer().catch(() => {
    throw new Error(`${lost} It was lost on the way.`);
  });
  return new File([bytes], name);
}
