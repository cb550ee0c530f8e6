/* SPDX-License-Identifier: Apache-2.0 */
/* Letters of 5 x 7 dots. */
#include "composite/picture_file.h"

#include <stdbool.h>
#include <string.h>

/* Seven rows of five dots each, the top one first, as digits of base 32; the left dot is the 16. */
static const struct Glyph {
    char letter;
    char rows[8];
} glyphs[] = {
    {'A', "ehhvhhh"},
    {'B', "uhhuhhu"},
    {'C', "ehggghe"},
    {'D', "uhhhhhu"},
    {'E', "vgguggv"},
    {'F', "vgguggg"},
    {'G', "ehgnhhf"},
    {'H', "hhhvhhh"},
    {'I', "e44444e"},
    {'J', "72222ic"},
    {'K', "hikokih"},
    {'L', "ggggggv"},
    {'M', "hrllhhh"},
    {'N', "hhpljhh"},
    {'O', "ehhhhhe"},
    {'P', "uhhuggg"},
    {'Q', "ehhhlid"},
    {'R', "uhhukih"},
    {'S', "fgge11u"},
    {'T', "v444444"},
    {'U', "hhhhhhe"},
    {'V', "hhhhha4"},
    {'W', "hhhllla"},
    {'X', "hha4ahh"},
    {'Y', "hha4444"},
    {'Z', "v1248gv"},
    {'a', "00e1fhf"},
    {'b', "gguhhhu"},
    {'c', "00egghe"},
    {'d', "11fhhhf"},
    {'e', "00ehvge"},
    {'f', "698s888"},
    {'g', "0fhhf1e"},
    {'h', "gguhhhh"},
    {'i', "40c444e"},
    {'j', "20622ic"},
    {'k', "ggikoki"},
    {'l', "c44444e"},
    {'m', "00qllhh"},
    {'n', "00uhhhh"},
    {'o', "00ehhhe"},
    {'p', "00uhugg"},
    {'q', "00fhf11"},
    {'r', "00mpggg"},
    {'s', "00fge1u"},
    {'t', "88s8896"},
    {'u', "00hhhjd"},
    {'v', "00hhha4"},
    {'w', "00hhlla"},
    {'x', "00ha4ah"},
    {'y', "00hhf1e"},
    {'z', "00v248v"},
    {'0', "ehjlphe"},
    {'1', "4c4444e"},
    {'2', "eh1248v"},
    {'3', "v2421he"},
    {'4', "26aiv22"},
    {'5', "vgu11he"},
    {'6', "68guhhe"},
    {'7', "v124888"},
    {'8', "ehhehhe"},
    {'9', "ehhf12c"},
    {'_', "000000v"},
    {'.', "00000cc"},
    {'-', "000v000"},
    {'+', "044v440"},
    {'=', "00v0v00"},
    {'(', "2488842"},
    {')', "8422248"},
    {':', "0cc0cc0"},
    {'/', "112448g"},
    {'#', "aavavaa"},
    {' ', "0000000"},
};
static const char unknown[] = "vhhhhhv";
enum { DOT = 2 };

static const char *rows_of(char letter) {
    for (size_t i = 0; i < sizeof glyphs / sizeof *glyphs; i++)
        if (glyphs[i].letter == letter) return glyphs[i].rows;
    return unknown;
}

static int digit(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

static void dot(uint8_t *rgb, size_t width, size_t height, size_t x, size_t y) {
    for (size_t j = y; j < y + DOT && j < height; j++)
        for (size_t i = x; i < x + DOT && i < width; i++) memset(rgb + 3 * (j * width + i), 230, 3);
}

void label_draw(uint8_t *rgb, size_t width, size_t height, size_t x, size_t y, const char *text) {
    for (; *text; text++, x += LABEL_STEP) {
        const char *rows = rows_of(*text);
        for (size_t row = 0; row < 7; row++)
            for (size_t column = 0; column < 5; column++)
                if (digit(rows[row]) >> (4 - column) & 1)
                    dot(rgb, width, height, x + DOT * column, y + DOT * row);
    }
}
