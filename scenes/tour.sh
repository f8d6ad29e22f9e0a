#!/bin/sh
# Renders the tour, one small scene a feature, to out/tour/NAME.png, and shows all of it on one page,
# out/tour/index.html. Installs and builds as first-render.sh does. Safe to run again.
set -eu
cd "$(dirname "$0")/.."
. scenes/build.sh
mkdir -p "$out/tour"

page=$out/tour/index.html
trap 'rm -f "$page.part"' EXIT
cat >"$page.part" <<'HTML'
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Fathom: the tour</title>
<style>
body { margin: 2em; font: 15px/1.4 sans-serif; color: #222; background: #f4f4f2 }
main { display: grid; grid-template-columns: repeat(auto-fill, 320px); gap: 2em }
figure { margin: 0 }
img { display: block; width: 320px; height: 240px }
figcaption { margin-top: 0.5em }
code { color: #666 }
</style>
</head>
<body>
<h1>Fathom: the tour</h1>
<main>
HTML
for scene in scenes/tour/*.json; do
    name=$(basename "$scene" .json)
    caption=$(sed -n 's/^  "name": "\(.*\)",$/\1/p' "$scene" | sed 's/&/\&amp;/g; s/</\&lt;/g')
    echo "Rendering $scene"
    "$fathom" render "$scene" --quiet -o "$out/tour/$name.png"
    cat >>"$page.part" <<HTML
<figure><img src="$name.png" alt=""><figcaption>$caption<br><code>$scene</code></figcaption></figure>
HTML
done
printf '</main>\n</body>\n</html>\n' >>"$page.part"
mv "$page.part" "$page"
echo "Done: open $page"
