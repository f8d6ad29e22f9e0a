/* The tree of nodes. The format gives each node one parent at most. Some exporters write nodes with several:
 * each further parent gets a copy of the node and of what is below it. */
#include "read/gltf/gltf_tree.h"

#include <stdlib.h>

/* Copies of nodes that each hold two copies of the next one double with each level. */
#define COPIES_MOST (1u << 16)

/* Nodes above a copy that are looked at for the node itself. A longer cycle makes copies up to their limit.
 */
#define LOOKS 64u

static bool is_above(const gltf *g, uint32_t link, uint32_t node, uint32_t looks) {
    for (; link != GLTF_ABSENT && looks; link = g->links.items[link].parent, --looks) {
        if (g->links.items[link].node == node) return true;
    }
    return false;
}

static void add_copy(gltf *g, const gltf_value *children, uint32_t parent, uint32_t node, uint32_t *out) {
    const bool full = g->links.count - gltf_count(&g->nodes) >= COPIES_MOST;
    if (is_above(g, parent, node, full ? UINT32_MAX : LOOKS))
        gltf_fail(g, children, NULL, "leads back to nodes[%u]: a node cannot contain itself", node);
    else if (full)
        gltf_fail(
            g, children, NULL,
            "names nodes[%u], which has another parent already; expected at most %u copies of nodes for "
            "their further parents",
            node, COPIES_MOST);
    else
        gltf_charge(g, children, NULL, 2 * sizeof(gltf_link)); /* the array grows to twice its size */
    if (parent < gltf_count(&g->nodes))
        gltf_note(g, children, NULL,
                  "a node with several parents, which is against the format, is shown below each of them");
    if (!gltf_fine(g)) return;
    *out = (uint32_t)g->links.count;
    const gltf_link copy = {.node = node, .parent = GLTF_ABSENT, .child = GLTF_ABSENT};
    if (!array_push(&g->links, copy)) gltf_fail_memory(g, sizeof copy);
}

/* named: for each node, 1 plus the last link that had it as a child. */
static void add_children(gltf *g, uint32_t parent, uint32_t *named) {
    gltf_value node, children;
    gltf_item(g, &g->nodes, g->links.items[parent].node, &node);
    gltf_array(g, &node, "children", &children);
    for (size_t k = 0; k < gltf_count(&children) && gltf_fine(g); ++k) {
        uint32_t child = GLTF_ABSENT;
        gltf_index_item(g, &children, k, &g->nodes, &child);
        if (!gltf_fine(g)) return;
        if (named[child] == parent + 1) {
            gltf_note(g, &children, NULL, "a node names a child twice; it is shown once");
            continue;
        }
        named[child] = parent + 1;
        if (g->links.items[child].parent != GLTF_ABSENT) add_copy(g, &children, parent, child, &child);
        if (!gltf_fine(g)) return;
        g->links.items[child].parent = parent;
        g->links.items[child].next = g->links.items[parent].child;
        g->links.items[parent].child = child;
    }
}

/* Each link has at most one parent, so one without a root above it is in a cycle or below one. Each link is
 * visited once: `seen` stores which walk upwards visited it. */
static void find_cycle(gltf *g, uint32_t *seen) {
    for (uint32_t i = 0; i < g->links.count && gltf_fine(g); ++i) {
        uint32_t k = i;
        while (k != GLTF_ABSENT && !seen[k]) {
            seen[k] = i + 1;
            k = g->links.items[k].parent;
        }
        if (k == GLTF_ABSENT || seen[k] != i + 1) continue;
        const uint32_t at = g->links.items[k].node;
        const gltf_value node = gltf_entry(&g->nodes, at);
        gltf_fail(g, &node, "children", "leads back to nodes[%u]: a node cannot contain itself", at);
    }
}

void gltf_tree_open(gltf *g) {
    const uint32_t count = (uint32_t)gltf_count(&g->nodes);
    uint32_t *named = calloc((size_t)count + 1, sizeof *named);
    if (!named || !array_room(&g->links, (size_t)count + 1)) gltf_fail_memory(g, count * sizeof *named);
    for (uint32_t i = 0; i < count && gltf_fine(g); ++i)
        g->links.items[g->links.count++] = (gltf_link){i, GLTF_ABSENT, GLTF_ABSENT, GLTF_ABSENT};
    for (uint32_t i = 0; i < g->links.count && gltf_fine(g); ++i) add_children(g, i, named);
    free(named);
    uint32_t *seen = calloc(g->links.count + 1, sizeof *seen);
    if (seen)
        find_cycle(g, seen);
    else
        gltf_fail_memory(g, g->links.count * sizeof *seen);
    free(seen);
}
