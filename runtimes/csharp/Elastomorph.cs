// From sliders to the weights of morph targets, as `extras.elastomorph` of a glTF mesh says.
//
// One file, .NET Standard 2.0 (Unity, Godot), no dependency. Read once, asked in every frame:
//
//     var bender = Elastomorph.Bender.FromJson(extras);   // the extras of the mesh
//     bender.Weights(sliders, weights);   // in the order of bender.Sliders and bender.Targets
//
// Version 0.2.0. SPDX-License-Identifier: MIT
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Text;

namespace Elastomorph
{
    /// <summary>Extras that do not fit: a sentence that says why.</summary>
    public sealed class ElastomorphException : Exception
    {
        public ElastomorphException(string why) : base(why) { }

        internal static void Unless(bool holds, string why)
        {
            if (!holds) throw new ElastomorphException(why);
        }
    }

    /// <summary>
    /// A piecewise polynomial: between breaks i and i + 1 it is Σ_n coefficients[i][n] (t − breaks[i])^n.
    /// </summary>
    public sealed class Curve
    {
        private readonly double[] breaks;
        private readonly double[][] coefficients;
        private readonly double startSlope, endSlope;

        public Curve(double[] breaks, double[][] coefficients)
        {
            var pieces = coefficients.Length;
            Demand(pieces > 0 && breaks.Length == pieces + 1 && breaks[0] == 0 && breaks[pieces] == 1);
            var terms = coefficients[0].Length;
            Demand(terms > 0 && terms <= 256);
            var largest = 1.0;
            for (var i = 0; i < pieces; i++)
            {
                Demand(breaks[i] < breaks[i + 1] && coefficients[i].Length == terms);
                foreach (var term in coefficients[i])
                {
                    Demand(!double.IsNaN(term) && !double.IsInfinity(term));
                    largest = Math.Max(largest, Math.Abs(term));
                }
            }
            this.breaks = breaks;
            this.coefficients = coefficients;
            var last = coefficients[pieces - 1];
            var width = 1 - breaks[pieces - 1];
            Demand(Math.Abs(coefficients[0][0]) <= 1e-9 * largest);
            Demand(Math.Abs(Value(last, width)) <= 1e-9 * largest);
            startSlope = terms > 1 ? coefficients[0][1] : 0;
            for (var n = terms - 1; n > 0; n--) endSlope = endSlope * width + n * last[n];
        }

        /// <summary>The value at a time: straight on along its end tangents outside [0, 1].</summary>
        public double At(double t)
        {
            if (t <= 0) return startSlope * t;
            if (t >= 1) return endSlope * (t - 1);
            int low = 0, high = coefficients.Length - 1;
            while (low < high)
            {
                var middle = (low + high + 1) / 2;
                if (breaks[middle] <= t) low = middle;
                else high = middle - 1;
            }
            return Value(coefficients[low], t - breaks[low]);
        }

        private static double Value(double[] row, double s)
        {
            var sum = 0.0;
            for (var n = row.Length - 1; n >= 0; n--) sum = sum * s + row[n];
            return sum;
        }

        private static void Demand(bool holds)
        {
            ElastomorphException.Unless(holds, "a curve is damaged");
        }
    }

    /// <summary>A morph target with a curve: the one of its name, or of several of a name that of its number.</summary>
    public struct Target
    {
        public string Name;
        public int? Index;
        public Curve Curve; // of a bend its weight; of a morph its fold, null where its weight is t itself
    }

    /// <summary>What is said of a path; filled by hand, or from extras by Description.From.</summary>
    public sealed class Morph
    {
        public string Name;
        public Target? Target; // null of a pair bend, which has bends alone
        public readonly List<Target> Bends = new List<Target>();

        internal IEnumerable<Target> Targets
        {
            get { return Target.HasValue ? new[] { Target.Value }.Concat(Bends) : Bends; }
        }
    }

    /// <summary>How the weight of a corrective comes of those of its drivers.</summary>
    public enum Law { Product, Min, Softmin, Hinge, AllMul, ExtMul, MulAvgExt, MulAvgAll }

    /// <summary>The drivers of a morph that several sliders drive, and their law.</summary>
    public sealed class Corrective
    {
        public readonly List<string> Drivers = new List<string>();
        public Law Law;
        public double[] Gains = new double[0]; // of a hinge, one a driver
        public double Sharpness; // of softmin, above 0

        internal void Check(string name)
        {
            ElastomorphException.Unless(Drivers.Count > 0, "a corrective has no drivers: " + name);
            ElastomorphException.Unless(
                Gains.Length == (Law == Law.Hinge ? Drivers.Count : 0)
                    && Gains.All(gain => !double.IsNaN(gain) && !double.IsInfinity(gain))
                    && (Law != Law.Softmin || (Sharpness > 0 && !double.IsInfinity(Sharpness))),
                "the numbers of a law do not fit: " + name);
        }

        /// <summary>The weight, from the values of the sliders of these numbers.</summary>
        internal double Weight(int[] drivers, Values values)
        {
            double product = 1, sum = 0, low = double.MaxValue, high = 0;
            for (var d = 0; d < drivers.Length; d++)
            {
                var value = values.Of(drivers[d]);
                if (Law >= Law.AllMul) value = Math.Min(value, 1);
                product *= value;
                sum += Law == Law.Hinge ? Gains[d] * value : value;
                low = Math.Min(low, value);
                high = Math.Max(high, value);
            }
            if (Law == Law.Product) return product;
            if (Law == Law.Hinge) return sum > 1 ? sum - 1 : 0;
            if (low <= 0) return 0;
            var mean = 0.0; // of powers relative to the least, so that none overflows
            switch (Law)
            {
                case Law.Min: return low;
                case Law.ExtMul: return low * high;
                case Law.MulAvgExt: return 2 * low * high / (low + high);
                case Law.MulAvgAll: return drivers.Length * product / sum;
                case Law.Softmin:
                    foreach (var slider in drivers) mean += Math.Pow(low / values.Of(slider), Sharpness);
                    return low * Math.Pow(mean / drivers.Length, -1 / Sharpness);
                default: return product;
            }
        }
    }

    /// <summary>Values of sliders in one precision or the other; those that are not there are 0.</summary>
    internal struct Values
    {
        public double[] Doubles;
        public float[] Singles;

        public double Of(int slider)
        {
            if (slider >= (Doubles == null ? Singles.Length : Doubles.Length)) return 0;
            var value = Doubles == null ? Singles[slider] : Doubles[slider];
            return double.IsNaN(value) || double.IsInfinity(value) ? 0 : value;
        }
    }

    /// <summary>
    /// What is said of a mesh. Targets that no morph names are straight paths of their own.
    /// </summary>
    public sealed class Description
    {
        private const int Newest = 3;
        private static readonly string[] Laws =
        {
            "product", "min", "softmin", "hinge", "allMul", "extMul", "mulAvgExt", "mulAvgAll"
        };

        public readonly List<string> Targets = new List<string>();
        public readonly List<Morph> Morphs = new List<Morph>();
        public readonly Dictionary<string, Corrective> Correctives = new Dictionary<string, Corrective>();

        /// <summary>The description in the extras of a mesh, which `Json.Read` read.</summary>
        public static Description From(object extras)
        {
            var made = new Description();
            made.Targets.AddRange(Texts(Key(extras, "targetNames") ?? new List<object>()));
            var own = Key(extras, "elastomorph");
            if (own == null) return made;
            var version = Key(own, "version") as double? ?? 0;
            ElastomorphException.Unless(version >= 1 && version % 1 == 0, "no version");
            ElastomorphException.Unless(version <= Newest, "a newer Elastomorph.cs is needed");
            foreach (var entry in Entries(own, "morphs"))
            {
                var fold = version > 1 && Has(entry, "fold") ? ReadCurve(Key(entry, "fold")) : null;
                var morph = new Morph { Name = Text(Key(entry, "name")) };
                if (version < 3 || Has(entry, "target")) morph.Target = ReadTarget(entry, version, fold);
                foreach (var bend in Entries(entry, "bends"))
                    morph.Bends.Add(ReadTarget(bend, version, ReadCurve(Key(bend, "curve"))));
                made.Morphs.Add(morph);
            }
            foreach (var entry in Entries(own, "correctives"))
            {
                var name = Text(Key(entry, "name"));
                ElastomorphException.Unless(!made.Correctives.ContainsKey(name), "a corrective twice: " + name);
                made.Correctives.Add(name, ReadCorrective(entry, version));
            }
            return made;
        }

        /// <summary>The extras of a mesh in a file of curves; extras themselves are given back.</summary>
        public static object ExtrasOf(object json, string mesh)
        {
            if (!Has(json, "meshes")) return json;
            ElastomorphException.Unless(Key(json, "version") as double? == 1, "a newer Elastomorph.cs is needed");
            var found = List(Key(json, "meshes"))
                .Where(own => string.IsNullOrEmpty(mesh) || Texts(Key(own, "names")).Contains(mesh)
                    || string.Format(CultureInfo.InvariantCulture, "{0}", Key(own, "mesh")) == mesh)
                .ToList();
            ElastomorphException.Unless(found.Count == 1, "the file of curves has not one mesh of that name");
            return found[0];
        }

        private static Target ReadTarget(object json, double version, Curve curve)
        {
            var index = version > 2 ? Key(json, "index") as double? ?? -1 : -1;
            return new Target
            {
                Name = Text(Key(json, "target")),
                Index = index >= 0 && index < int.MaxValue && index % 1 == 0 ? (int?)index : null,
                Curve = curve
            };
        }

        private static Corrective ReadCorrective(object json, double version)
        {
            var made = new Corrective();
            made.Drivers.AddRange(Texts(Key(json, "drivers")));
            if (version < 3) return made;
            if (Has(json, "law"))
            {
                var law = Text(Key(json, "law"));
                made.Law = (Law)Array.FindIndex(Laws, own => own == law);
                ElastomorphException.Unless(made.Law >= 0, "a law is not known: " + law);
            }
            ElastomorphException.Unless(
                Has(json, "gains") == (made.Law == Law.Hinge)
                    && Has(json, "sharpness") == (made.Law == Law.Softmin),
                "a law lacks its numbers, or has those of another");
            if (Has(json, "gains")) made.Gains = Numbers(Key(json, "gains"));
            made.Sharpness = Key(json, "sharpness") as double? ?? 0;
            return made;
        }

        private static Curve ReadCurve(object json)
        {
            return new Curve(Numbers(Key(json, "breaks")), List(Key(json, "coefficients")).Select(Numbers).ToArray());
        }

        private static bool Has(object json, string key)
        {
            var holder = json as Dictionary<string, object>;
            ElastomorphException.Unless(holder != null, "an object was expected");
            return holder.ContainsKey(key);
        }

        private static object Key(object json, string key)
        {
            return Has(json, key) ? ((Dictionary<string, object>)json)[key] : null;
        }

        /// <summary>An empty list may have been left out.</summary>
        private static List<object> Entries(object json, string key)
        {
            return Has(json, key) ? List(Key(json, key)) : new List<object>();
        }

        private static List<object> List(object json)
        {
            ElastomorphException.Unless(json is List<object>, "a list was expected");
            return (List<object>)json;
        }

        private static string Text(object json)
        {
            ElastomorphException.Unless(json is string, "a text was expected");
            return (string)json;
        }

        private static List<string> Texts(object json)
        {
            return List(json).Select(Text).ToList();
        }

        private static double[] Numbers(object json)
        {
            var list = List(json);
            ElastomorphException.Unless(list.All(entry => entry is double), "a number was expected");
            return list.Cast<double>().ToArray();
        }
    }

    /// <summary>The weights of one mesh: made once, asked in every frame.</summary>
    public sealed class Bender
    {
        private readonly string[] sliders, targets;
        private readonly int[][] drivers; // of each morph, numbers of sliders
        private readonly Corrective[] laws; // of each morph, how its weight comes of theirs
        private readonly int[][] places; // of each morph, its target and those of its bends
        private readonly Curve[][] curves; // likewise; the first is a fold, or null
        private readonly bool[] whole; // of each morph, whether its first target has its whole displacement

        public Bender(Description described)
        {
            targets = described.Targets.ToArray();
            var free = new HashSet<int>(Enumerable.Range(0, targets.Length));
            var morphs = described.Morphs.ToList();
            var taken = morphs.Select(m => m.Targets.Select(target => Take(free, target)).ToArray()).ToList();
            foreach (var place in free.OrderBy(number => number))
            {
                morphs.Add(new Morph { Name = targets[place], Target = new Target() });
                taken.Add(new[] { place });
            }
            places = taken.ToArray();
            var names = new HashSet<string>(morphs.Select(morph => morph.Name), StringComparer.Ordinal);
            ElastomorphException.Unless(names.Count == morphs.Count, "two morphs of one name");

            var correctives = described.Correctives;
            foreach (var own in correctives)
            {
                ElastomorphException.Unless(names.Contains(own.Key), "a corrective is no morph: " + own.Key);
                own.Value.Check(own.Key);
                foreach (var driver in own.Value.Drivers)
                    ElastomorphException.Unless(
                        names.Contains(driver) && (driver == own.Key || !correctives.ContainsKey(driver)),
                        "a driver of " + own.Key + " is no slider of its own: " + driver);
            }
            Func<string, List<string>> driversOf = name =>
                correctives.ContainsKey(name) ? correctives[name].Drivers : new List<string> { name };
            sliders = morphs.Select(m => m.Name).Where(name => driversOf(name).Contains(name)).ToArray();
            whole = morphs.Select(m => m.Target.HasValue).ToArray();
            foreach (var morph in morphs)
                ElastomorphException.Unless(
                    morph.Target.HasValue || !driversOf(morph.Name).Contains(morph.Name),
                    "a slider has no target: " + morph.Name);
            var alone = new Corrective();
            laws = morphs.Select(m => correctives.ContainsKey(m.Name) ? correctives[m.Name] : alone).ToArray();
            var column = new Dictionary<string, int>(StringComparer.Ordinal);
            foreach (var name in sliders) column.Add(name, column.Count);
            drivers = morphs
                .Select(m => driversOf(m.Name).Select(driver => column[driver]).ToArray())
                .ToArray();
            curves = morphs.Select(m => m.Targets.Select(target => target.Curve).ToArray()).ToArray();
        }

        /// <summary>
        /// From the extras of a mesh, an object with targetNames and elastomorph; or from a file of curves
        /// and the name of the mesh, of its node, or its number: of one mesh without any.
        /// </summary>
        public static Bender FromJson(string text, string mesh = null)
        {
            return new Bender(Description.From(Description.ExtrasOf(Json.Read(text), mesh)));
        }

        /// <summary>Names of the sliders, in the order of their values.</summary>
        public IReadOnlyList<string> Sliders { get { return sliders; } }

        /// <summary>Names of the morph targets, in the order of their weights.</summary>
        public IReadOnlyList<string> Targets { get { return targets; } }

        /// <summary>
        /// Reads Sliders.Count values and writes Targets.Count weights; allocates nothing. Values that
        /// are not there are 0, and weights without a place are not written.
        /// </summary>
        public void Weights(double[] values, double[] weights)
        {
            var given = new Values { Doubles = values };
            for (var m = 0; m < places.Length; m++)
            {
                var t = laws[m].Weight(drivers[m], given);
                for (var k = 0; k < places[m].Length; k++)
                    if (places[m][k] < weights.Length) weights[places[m][k]] = Weight(m, k, t);
            }
        }

        /// <summary>The same in single precision.</summary>
        public void Weights(float[] values, float[] weights)
        {
            var given = new Values { Singles = values };
            for (var m = 0; m < places.Length; m++)
            {
                var t = laws[m].Weight(drivers[m], given);
                for (var k = 0; k < places[m].Length; k++)
                    if (places[m][k] < weights.Length) weights[places[m][k]] = (float)Weight(m, k, t);
            }
        }

        private double Weight(int morph, int k, double t)
        {
            var curve = curves[morph][k];
            return (k == 0 && whole[morph] ? t : 0) + (curve == null ? 0 : curve.At(t));
        }

        private int Take(HashSet<int> free, Target target)
        {
            var place = target.Index ?? -1;
            if (place < 0 || place >= targets.Length || targets[place] != target.Name)
            {
                place = Array.IndexOf(targets, target.Name);
                if (place != Array.LastIndexOf(targets, target.Name)) place = -1;
            }
            ElastomorphException.Unless(
                free.Remove(place), "a morph target is missing or used twice: " + target.Name);
            return place;
        }
    }

    /// <summary>
    /// JSON as null, bool, double, string, List&lt;object&gt; and Dictionary&lt;string, object&gt;.
    /// </summary>
    public sealed class Json
    {
        private const int MostDepth = 64;
        private const string Escapes = "\"\\/bfnrt", Escaped = "\"\\/\b\f\n\r\t";
        private readonly string text;
        private int at;

        private Json(string text) { this.text = text; }

        public static object Read(string text)
        {
            var reader = new Json(text);
            var found = reader.Value(0);
            Demand(reader.Peek() == '\0' && reader.at == text.Length);
            return found;
        }

        private static void Demand(bool holds)
        {
            ElastomorphException.Unless(holds, "damaged JSON");
        }

        private char Peek()
        {
            while (at < text.Length && " \t\r\n".IndexOf(text[at]) >= 0) at++;
            return at < text.Length ? text[at] : '\0';
        }

        private bool Take(char wanted)
        {
            var found = Peek() == wanted;
            if (found) at++;
            return found;
        }

        private bool Word(string wanted)
        {
            var found = string.CompareOrdinal(text, at, wanted, 0, wanted.Length) == 0;
            if (found) at += wanted.Length;
            return found;
        }

        private object Value(int depth)
        {
            Demand(depth <= MostDepth);
            switch (Peek())
            {
                case '{': return Object(depth);
                case '[': return List(depth);
                case '"': return Text();
            }
            if (Word("null")) return null;
            if (Word("true")) return true;
            if (Word("false")) return false;
            return Number();
        }

        private Dictionary<string, object> Object(int depth)
        {
            var made = new Dictionary<string, object>(StringComparer.Ordinal);
            at++;
            if (Take('}')) return made;
            do
            {
                Demand(Peek() == '"');
                var key = Text();
                Demand(Take(':'));
                made[key] = Value(depth + 1);
            } while (Take(','));
            Demand(Take('}'));
            return made;
        }

        private List<object> List(int depth)
        {
            var made = new List<object>();
            at++;
            if (Take(']')) return made;
            do made.Add(Value(depth + 1)); while (Take(','));
            Demand(Take(']'));
            return made;
        }

        private double Number()
        {
            var start = at;
            while (at < text.Length && "+-.0123456789eE".IndexOf(text[at]) >= 0) at++;
            double found;
            Demand(double.TryParse(
                text.Substring(start, at - start), NumberStyles.Float, CultureInfo.InvariantCulture, out found));
            Demand(!double.IsInfinity(found));
            return found;
        }

        private string Text()
        {
            var made = new StringBuilder();
            for (at++; at < text.Length && text[at] != '"'; at++)
            {
                if (text[at] != '\\')
                {
                    made.Append(text[at]);
                    continue;
                }
                Demand(++at < text.Length);
                var place = Escapes.IndexOf(text[at]);
                if (place >= 0)
                {
                    made.Append(Escaped[place]);
                    continue;
                }
                Demand(text[at] == 'u' && at + 4 < text.Length);
                int code;
                Demand(int.TryParse(
                    text.Substring(at + 1, 4), NumberStyles.AllowHexSpecifier, CultureInfo.InvariantCulture, out code));
                made.Append((char)code);
                at += 4;
            }
            Demand(at++ < text.Length);
            return made.ToString();
        }
    }
}
