// SPDX-License-Identifier: MIT
// What the builders of pages share.

const PIECE = 8000;  // characters of one string literal; compilers are asked for no more than they must bear

/** A script as it may stand in an HTML file: nothing in it ends the element. */
export function scriptText(text, name) {
  if (/<\/script|<!--/i.test(text)) {
    throw new Error(`${name} holds text that would end its <script> element`);
  }
  return text;
}

/** C++ string literals, one after the other, that make up the text. */
export function literals(text) {
  const delimiter = 'limber_page';
  if (text.includes(`)${delimiter}"`)) {
    throw new Error('the page holds the delimiter of its own literals');
  }
  const lines = [];
  for (let begin = 0; begin < text.length;) {
    let end = Math.min(begin + PIECE, text.length);
    const last = text.charCodeAt(end - 1);
    end += last >= 0xd800 && last <= 0xdbff ? 1 : 0;  // never within a character of two code units
    lines.push(`R"${delimiter}(${text.slice(begin, end)})${delimiter}"`);
    begin = end;
  }
  return lines.join('\n');
}
