// Reads extras cut short and changed everywhere: nothing but an ElastomorphException comes of it.
using System;
using System.IO;
using System.Linq;
using System.Text;
using Elastomorph;

internal static class Hostile
{
    private static int posed;

    private static void Pose(string text)
    {
        try
        {
            var bender = Bender.FromJson(text);
            bender.Weights(new float[bender.Sliders.Count], new float[bender.Targets.Count]);
            posed++;
        }
        catch (ElastomorphException)
        {
        }
    }

    /// <summary>Whether a million frames make the collector work.</summary>
    private static bool Allocates(Bender bender)
    {
        var values = Enumerable.Repeat(0.3f, bender.Sliders.Count).ToArray();
        var weights = new float[bender.Targets.Count];
        GC.Collect();
        var before = GC.CollectionCount(0);
        for (var frame = 0; frame < 1000000; frame++) bender.Weights(values, weights);
        return GC.CollectionCount(0) > before;
    }

    private static int Main(string[] words)
    {
        var text = File.ReadAllText(words[0]);
        Pose(text);
        if (posed != 1) return 1;
        for (var end = 0; end < text.Length; end++) Pose(text.Substring(0, end));
        if (posed != 1) return 2; // none of the shorter ones is complete
        for (var at = 0; at < text.Length; at++)
            foreach (var other in "\"\\{}[],9-\0\uffffu")
            {
                var changed = new StringBuilder(text);
                changed[at] = other;
                Pose(changed.ToString());
            }
        Pose(new string('[', 1000000));
        Pose(string.Concat(Enumerable.Repeat("{\"a\":", 100000)));
        if (Allocates(Bender.FromJson(text))) return 3;
        Console.WriteLine(posed);
        return 0;
    }
}
