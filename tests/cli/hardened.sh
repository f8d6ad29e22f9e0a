# The protections of the program, the library and the image module: tables of addresses that are filled
# when they are loaded and read-only from then on, code at any address, no code on stacks or written to when loaded, canaries.
. "$SOURCE/tests/cli/check.inc"

# has FILE PATTERN / has_not FILE PATTERN: of what readelf says of it.
has() { grep -Eq -e "$2" elf.txt || die "$1: readelf shows no $2"; }
has_not() { ! grep -Eq -e "$2" elf.txt || die "$1: readelf shows $2"; }

for file in "$FATHOM" "$BUILD/lib/libfathom.so" "$BUILD/lib/fathom/fathom_image.so" "$BUILD/lib/fathom/fathom-image"; do
    readelf --wide --file-header --program-headers --dynamic "$file" >elf.txt
    has "$file" '^ *Type: +DYN'
    has "$file" '^ *GNU_RELRO '
    has "$file" '\((FLAGS|BIND_NOW|FLAGS_1)\).*NOW'
    has "$file" '^ *GNU_STACK .* RW '
    has_not "$file" '^ *GNU_STACK .* RWE'
    has_not "$file" '^ *LOAD .* RWE'
    has_not "$file" 'TEXTREL'
done
readelf --wide --dynamic "$FATHOM" >elf.txt
has "$FATHOM" 'FLAGS_1.* PIE'

# Sanitizers have their own canaries and checks.
[ -z "$SANITIZE" ] || exit 0
for file in "$FATHOM" "$BUILD/lib/libfathom.so"; do
    readelf --wide --symbols "$file" >elf.txt
    has "$file" ' __stack_chk_fail(@|$| )'
    has "$file" ' __[a-z]+_chk(@|$| )'
done
