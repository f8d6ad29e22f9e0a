// Runs in a copy of the page, in the browser, and leaves what it found on <html>: data-probe="ok" or the faults.
const faults = [];
document.querySelectorAll('details').forEach(part => part.open = true);
const around = element => element.getBoundingClientRect();
const overlap = (a, b) =>
    a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 2 && b.top < a.bottom - 2;

for (const holder of document.querySelectorAll('[data-marks]')) {
    const marks = [...holder.querySelectorAll('.mark')];
    const name = holder.querySelector('title, caption, h3')?.textContent;
    if (marks.length !== Number(holder.dataset.marks) || !marks.length) faults.push(`${name}: ${marks.length} marks`);
    const frame = around(holder);
    for (const mark of marks) {
        const box = around(mark);
        // Tables may scroll, plots may not lose a mark.
        const inside = holder.tagName === 'DIV' || box.left >= frame.left - 1 && box.right <= frame.right + 1 && box.top >= frame.top - 1 &&
            box.bottom <= frame.bottom + 1;
        if (!box.width || !box.height || !inside) faults.push(`${name}: a mark is empty or outside`);
    }
}
for (const svg of document.querySelectorAll('svg')) {
    const texts = [...svg.querySelectorAll('text')], boxes = texts.map(around), frame = around(svg);
    texts.forEach((text, i) => {
        const words = text.textContent;
        if (!boxes[i].width) faults.push(`no font for: ${words}`);
        if (boxes[i].left < frame.left - 1 || boxes[i].right > frame.right + 1) faults.push(`cut off: ${words}`);
        for (let k = 0; k < i; ++k) {
            if (overlap(boxes[i], boxes[k])) faults.push(`overlap: ${texts[k].textContent} and ${words}`);
        }
    });
}
for (const image of document.images) {
    if (!image.naturalWidth) faults.push(`no image: ${image.alt}`);
}
if (document.documentElement.scrollWidth > document.documentElement.clientWidth) faults.push('wider than the window');
document.documentElement.dataset.probe = faults.length ? faults.join('; ') : 'ok';
