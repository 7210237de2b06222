// Answers a file of the conformance kit: `mono Conform.exe ../conformance/vectors/folds.json`.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using Elastomorph;

internal static class Conform
{
    private static void Main(string[] words)
    {
        var content = Json.Read(File.ReadAllText(words[0]));
        var entries = content as List<object>;
        var answers = entries != null
            ? entries.Select(entry => Refusal((Dictionary<string, object>)entry))
            : Weights((Dictionary<string, object>)content);
        Console.WriteLine("[" + string.Join(", ", answers) + "]");
    }

    private static string Refusal(Dictionary<string, object> entry)
    {
        try
        {
            new Bender(Description.From(entry["extras"]));
            return "null";
        }
        catch (ElastomorphException)
        {
            return "\"refused\"";
        }
    }

    private static IEnumerable<string> Weights(Dictionary<string, object> vector)
    {
        var extras = vector.ContainsKey("curves")
            ? Description.ExtrasOf(vector["curves"], (string)vector["mesh"])
            : vector["extras"];
        var bender = new Bender(Description.From(extras));
        foreach (Dictionary<string, object> pose in (List<object>)vector["poses"])
        {
            var named = (Dictionary<string, object>)pose["sliders"];
            var values = bender.Sliders.Select(s => named.ContainsKey(s) ? (double)named[s] : double.NaN).ToArray();
            var weights = new double[bender.Targets.Count];
            var single = new float[bender.Targets.Count];
            bender.Weights(values, weights);
            bender.Weights(Array.ConvertAll(values, value => (float)value), single);
            yield return "{\"double\": [" + string.Join(", ", weights.Select(Text)) + "], \"single\": ["
                + string.Join(", ", single.Select(weight => Text(weight))) + "]}";
        }
    }

    private static string Text(double number)
    {
        return number.ToString("R", CultureInfo.InvariantCulture);
    }
}
