!> LU factors of a small sparse matrix, real or complex. The pivots of one search serve until they become unfit for other values;
!> which entry is taken from which is listed once, so that factors cost little more than their products. Floor: multibody. Source:
!> Duff, Erisman and Reid, Direct Methods for Sparse Matrices, chapters 5, 7 and 9.
module limber_multibody_small_sparse_lu
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: small_lu_type

   !> Least part of the largest entry of its column, rows divided by their largest entries, that a pivot is
   real(wp), parameter :: threshold = 0.1_wp
   !> Largest multiplier, of rows so divided, up to which pivots serve again: behind a search multipliers are far below
   real(wp), parameter :: largest_multiplier = 1.0e3_wp
   !> Order of elimination of one pattern, and the factors: rows of pivots one behind the other, each with its multipliers, the
   !> reciprocal pivot and the rest of its row, in the order of the pivots
   type :: small_lu_type
      !> Number of unknowns; none before the first search
      integer :: n = 0
      !> Row and column of the matrix in which each pivot stands (n)
      integer, allocatable, private :: rows(:), columns(:)
      !> Begin of each row of the factors (n + 1), place of its pivot (n), pivot of each place (places)
      integer, allocatable, private :: first(:), diagonal(:), column(:)
      !> Place of each entry of the matrix (entries); places that are no entries
      integer, allocatable, private :: place(:), fills(:)
      !> Of each multiplier: place of the first product that is taken away with it where all these stand side by side, else zero
      !> (places); places of all others, in the order of the elimination
      integer, allocatable, private :: begin(:), target(:)
      !> Factor of each multiplier for the comparison with `largest_multiplier` (places)
      real(wp), allocatable, private :: weight(:)
      !> Factors, reciprocal pivots on the diagonal (places), and those of a complex matrix, real and imaginary parts (places, 2);
      !> scratch (n), (n, 2)
      real(wp), allocatable, private :: a(:), z(:, :), x(:), y(:, :)
   contains
      procedure :: seek, follow, renew, renew_complex, solve, solve_complex
   end type small_lu_type

contains

   !> Seeks pivots: of those that are large enough in their columns one that fills little. Factors come by `renew`.
   pure subroutine seek(self, n, first, row, values, singular)
      class(small_lu_type), intent(inout) :: self
      integer, intent(in) :: n
      !> First entry of each column (n + 1) and row of each entry, from zero
      integer, intent(in) :: first(:), row(:)
      complex(wp), intent(in) :: values(:)
      !> True if no pivot but zero is left
      logical, intent(out) :: singular
      complex(wp) :: a(n, n)
      real(wp) :: largest(n)
      logical :: held(n, n)
      integer :: rows(n), columns(n), step, k, column
      self%n = 0
      a = (0.0_wp, 0.0_wp)
      held = .false.
      largest = 0.0_wp
      do column = 1, n
         do k = first(column) + 1, first(column + 1)
            a(row(k) + 1, column) = values(k)
            held(row(k) + 1, column) = .true.
            largest(row(k) + 1) = max(largest(row(k) + 1), extent(values(k)))
         end do
      end do
      rows = [(k, k=1, n)]
      columns = rows
      singular = .not. all(largest > 0.0_wp)
      if (singular) return
      do step = 1, n
         call choose(n, step, a, held, largest, rows, columns, singular)
         if (singular) return
         call eliminate(n, step, rows, columns, a, held)
      end do
      call list_places(self, n, first, row, held, largest, rows, columns)
   end subroutine seek

   !> Takes over the pivots of another matrix of the same pattern, which has some. Factors come by `renew`.
   pure subroutine follow(self, other)
      class(small_lu_type), intent(inout) :: self
      type(small_lu_type), intent(in) :: other
      call forget(self)
      allocate (self%rows, source=other%rows)
      allocate (self%columns, source=other%columns)
      allocate (self%first, source=other%first)
      allocate (self%diagonal, source=other%diagonal)
      allocate (self%column, source=other%column)
      allocate (self%place, source=other%place)
      allocate (self%fills, source=other%fills)
      allocate (self%begin, source=other%begin)
      allocate (self%target, source=other%target)
      allocate (self%weight, source=other%weight)
      allocate (self%a, source=other%a)
      allocate (self%z, source=other%z)
      allocate (self%x, source=other%x)
      allocate (self%y, source=other%y)
      self%n = other%n
   end subroutine follow

   !> Gives the memory of the last search back.
   pure subroutine forget(self)
      class(small_lu_type), intent(inout) :: self
      self%n = 0
      if (allocated(self%a)) deallocate (self%rows, self%columns, self%first, self%diagonal, self%column, self%place, self%fills, &
         & self%begin, self%target, self%weight, self%a, self%z, self%x, self%y)
   end subroutine forget

   !> Size of a complex number, at little cost.
   pure real(wp) function extent(z)
      complex(wp), intent(in) :: z
      extent = abs(real(z, wp)) + abs(aimag(z))
   end function extent

   !> Brings the next pivot to the front of what is left: one with the fewest products, of these one with the fewest entries in its
   !> column, and of these the largest.
   pure subroutine choose(n, step, a, held, largest, rows, columns, singular)
      integer, intent(in) :: n, step
      !> Matrix, places that can hold an entry, largest entries of the rows at first
      complex(wp), intent(in) :: a(n, n)
      real(wp), intent(in) :: largest(n)
      logical, intent(in) :: held(n, n)
      !> Rows and columns: those of the pivots so far, then the others
      integer, intent(inout) :: rows(n), columns(n)
      logical, intent(out) :: singular
      real(wp) :: part(n), most, best
      integer :: along(n), across, i, j, cost(2), least(2), row, column
      do i = step, n
         along(i) = count(held(rows(i), columns(step:n)))
      end do
      least = huge(least)
      best = 0.0_wp
      row = 0
      column = 0
      do j = step, n
         across = 0
         do i = step, n
            part(i) = 0.0_wp
            if (.not. held(rows(i), columns(j))) cycle
            across = across + 1
            part(i) = extent(a(rows(i), columns(j)))/largest(rows(i))
         end do
         most = maxval(part(step:n))
         if (.not. most > 0.0_wp) cycle
         do i = step, n
            if (part(i) < threshold*most) cycle
            cost = [(along(i) - 1)*(across - 1), across]
            if (cost(1) > least(1) .or. (cost(1) == least(1) .and. cost(2) > least(2))) cycle
            if (all(cost == least) .and. part(i) <= best) cycle
            least = cost
            best = part(i)
            row = i
            column = j
         end do
      end do
      singular = row == 0
      if (singular) return
      rows([step, row]) = rows([row, step])
      columns([step, column]) = columns([column, step])
   end subroutine choose

   !> Takes a pivot out of the rows behind it.
   pure subroutine eliminate(n, step, rows, columns, a, held)
      integer, intent(in) :: n, step, rows(n), columns(n)
      complex(wp), intent(inout) :: a(n, n)
      logical, intent(inout) :: held(n, n)
      complex(wp) :: multiplier
      integer :: i, j
      do i = step + 1, n
         if (.not. held(rows(i), columns(step))) cycle
         multiplier = a(rows(i), columns(step))/a(rows(step), columns(step))
         do j = step + 1, n
            if (.not. held(rows(step), columns(j))) cycle
            a(rows(i), columns(j)) = a(rows(i), columns(j)) - multiplier*a(rows(step), columns(j))
            held(rows(i), columns(j)) = .true.
         end do
      end do
   end subroutine eliminate

   !> Lists the places of the factors, and what is taken from which.
   pure subroutine list_places(self, n, first, row, held, largest, rows, columns)
      class(small_lu_type), intent(inout) :: self
      integer, intent(in) :: n, first(:), row(:), rows(n), columns(n)
      !> Places that the pivots leave with an entry
      logical, intent(in) :: held(n, n)
      real(wp), intent(in) :: largest(n)
      integer :: at(n, n), i, j, k, p, places
      logical, allocatable :: met(:)
      places = count(held)
      call forget(self)
      allocate (self%first(n + 1), self%diagonal(n), self%column(places), self%place(size(row)), self%weight(places))
      allocate (self%a(places), self%z(places, 2), self%x(n), self%y(n, 2), source=0.0_wp)
      allocate (self%begin(places), source=0)
      allocate (self%rows, source=rows)
      allocate (self%columns, source=columns)
      at = 0
      p = 0
      do i = 1, n
         self%first(i) = p + 1
         do k = 1, n
            if (.not. held(rows(i), columns(k))) cycle
            p = p + 1
            at(rows(i), columns(k)) = p
            self%column(p) = k
            self%weight(p) = largest(rows(k))/largest(rows(i))
            if (k == i) self%diagonal(i) = p
         end do
      end do
      self%first(n + 1) = p + 1
      self%n = n
      allocate (met(places), source=.false.)
      do j = 1, n
         do k = first(j) + 1, first(j + 1)
            self%place(k) = at(row(k) + 1, j)
            met(self%place(k)) = .true.
         end do
      end do
      allocate (self%fills, source=pack([(p, p=1, places)], .not. met))
      call list_products(self, rows, columns, at)
   end subroutine list_places

   !> Lists the places that products are taken away from.
   pure subroutine list_products(self, rows, columns, at)
      class(small_lu_type), intent(inout) :: self
      !> Rows and columns of the pivots (n), places of the factors (n, n)
      integer, intent(in) :: rows(:), columns(:), at(:, :)
      !> Products side by side that are worth a loop of their own
      integer, parameter :: few = 4
      integer, allocatable :: target(:)
      integer :: i, k, p, from, number, products
      allocate (target(products_of(self)))
      products = 0
      do i = 1, self%n
         do p = self%first(i), self%diagonal(i) - 1
            from = self%diagonal(self%column(p))
            number = self%first(self%column(p) + 1) - 1 - from
            do k = 1, number
               target(products + k) = at(rows(i), columns(self%column(from + k)))
            end do
            if (number >= few) then
               if (target(products + number) - target(products + 1) == number - 1) then
                  self%begin(p) = target(products + 1)
                  cycle
               end if
            end if
            products = products + number
         end do
      end do
      allocate (self%target, source=target(:products))
   end subroutine list_products

   !> Number of products of an elimination.
   pure integer function products_of(self) result(products)
      class(small_lu_type), intent(in) :: self
      integer :: i, p
      products = 0
      do i = 1, self%n
         do p = self%first(i), self%diagonal(i) - 1
            products = products + self%first(self%column(p) + 1) - 1 - self%diagonal(self%column(p))
         end do
      end do
   end function products_of

   !> Factors of other values with these pivots.
   pure subroutine renew(self, values, unfit)
      class(small_lu_type), intent(inout) :: self
      real(wp), contiguous, intent(in) :: values(:)
      !> True if the pivots are unfit for them: there are no factors
      logical, intent(out) :: unfit
      call factor(self%n, size(values), size(self%fills), size(self%column), size(self%target), self%place, self%fills, &
         & self%first, self%diagonal, self%column, self%begin, self%target, self%weight, values, self%a, unfit)
   end subroutine renew

   !> The factors of real values.
   pure subroutine factor(n, entries, zeros, places, products, place, fills, first, diagonal, column, begin, target, &
      & weight, values, a, unfit)
      integer, intent(in) :: n, entries, zeros, places, products
      integer, intent(in) :: place(entries), fills(zeros), first(n + 1), diagonal(n), column(places), begin(places), &
         & target(products)
      real(wp), intent(in) :: weight(places), values(entries)
      real(wp), intent(inout) :: a(places)
      logical, intent(out) :: unfit
      real(wp) :: multiplier
      integer :: i, k, p, q, step
      do k = 1, zeros
         a(fills(k)) = 0.0_wp
      end do
      do k = 1, entries
         a(place(k)) = values(k)
      end do
      step = 0
      unfit = .true.
      do i = 1, n
         do p = first(i), diagonal(i) - 1
            k = column(p)
            multiplier = a(p)*a(diagonal(k))
            a(p) = multiplier
            if (abs(multiplier)*weight(p) > largest_multiplier) return
            if (begin(p) > 0) then
               q = first(k + 1) - 1 - diagonal(k)
               call take(q, multiplier, a(diagonal(k) + 1), a(begin(p)))
               cycle
            end if
            do q = diagonal(k) + 1, first(k + 1) - 1
               step = step + 1
               a(target(step)) = a(target(step)) - multiplier*a(q)
            end do
         end do
         if (abs(a(diagonal(i))) < tiny(multiplier)) return
         a(diagonal(i)) = 1/a(diagonal(i))
      end do
      unfit = .false.
   end subroutine factor

   !> Takes a multiple of a row from another one.
   pure subroutine take(n, multiplier, other, row)
      integer, intent(in) :: n
      real(wp), intent(in) :: multiplier, other(n)
      real(wp), intent(inout) :: row(n)
      integer :: j
      do j = 1, n
         row(j) = row(j) - multiplier*other(j)
      end do
   end subroutine take

   !> The same as `renew` of a complex matrix.
   pure subroutine renew_complex(self, values, unfit)
      class(small_lu_type), intent(inout) :: self
      complex(wp), contiguous, intent(in) :: values(:)
      logical, intent(out) :: unfit
      call factor_complex(self%n, size(values), size(self%fills), size(self%column), size(self%target), self%place, self%fills, &
         & self%first, self%diagonal, self%column, self%begin, self%target, self%weight, values, self%z(:, 1), self%z(:, 2), &
         & unfit)
   end subroutine renew_complex

   !> The factors of complex values.
   pure subroutine factor_complex(n, entries, zeros, places, products, place, fills, first, diagonal, column, begin, target, &
      & weight, values, a, b, unfit)
      integer, intent(in) :: n, entries, zeros, places, products
      integer, intent(in) :: place(entries), fills(zeros), first(n + 1), diagonal(n), column(places), begin(places), &
         & target(products)
      real(wp), intent(in) :: weight(places)
      complex(wp), intent(in) :: values(entries)
      !> Real and imaginary parts
      real(wp), intent(inout) :: a(places), b(places)
      logical, intent(out) :: unfit
      real(wp) :: s, t, u, v
      integer :: i, k, p, q, step
      do k = 1, zeros
         a(fills(k)) = 0.0_wp
         b(fills(k)) = 0.0_wp
      end do
      do k = 1, entries
         a(place(k)) = real(values(k), wp)
         b(place(k)) = aimag(values(k))
      end do
      step = 0
      unfit = .true.
      do i = 1, n
         do p = first(i), diagonal(i) - 1
            k = column(p)
            q = diagonal(k)
            s = a(p)*a(q) - b(p)*b(q)
            t = a(p)*b(q) + b(p)*a(q)
            a(p) = s
            b(p) = t
            if ((abs(s) + abs(t))*weight(p) > largest_multiplier) return
            if (begin(p) > 0) then
               call take_complex(first(k + 1) - 1 - q, s, t, a(q + 1), b(q + 1), a(begin(p)), b(begin(p)))
               cycle
            end if
            do q = diagonal(k) + 1, first(k + 1) - 1
               step = step + 1
               u = a(target(step)) - (s*a(q) - t*b(q))
               v = b(target(step)) - (s*b(q) + t*a(q))
               a(target(step)) = u
               b(target(step)) = v
            end do
         end do
         p = diagonal(i)
         if (abs(a(p)) + abs(b(p)) < tiny(s)) return
         call invert(a(p), b(p))
      end do
      unfit = .false.
   end subroutine factor_complex

   !> Takes s + i t times a complex row a + i b from another one.
   pure subroutine take_complex(n, s, t, a, b, x, y)
      integer, intent(in) :: n
      real(wp), intent(in) :: s, t, a(n), b(n)
      real(wp), intent(inout) :: x(n), y(n)
      integer :: j
      do j = 1, n
         x(j) = x(j) - (s*a(j) - t*b(j))
         y(j) = y(j) - (s*b(j) + t*a(j))
      end do
   end subroutine take_complex

   !> Reciprocal of a complex number.
   elemental subroutine invert(a, b)
      real(wp), intent(inout) :: a, b
      real(wp) :: ratio, part
      if (abs(a) >= abs(b)) then
         ratio = b/a
         part = 1/(a + b*ratio)
         a = part
         b = -ratio*part
      else
         ratio = a/b
         part = 1/(b + a*ratio)
         a = ratio*part
         b = -part
      end if
   end subroutine invert

   !> Solves in place with the factors.
   pure subroutine solve(self, right)
      class(small_lu_type), intent(inout) :: self
      !> Right-hand side, then solution (n)
      real(wp), contiguous, intent(inout) :: right(:)
      if (self%n > 0) call substitute(self%n, size(self%column), self%rows, self%columns, self%first, self%diagonal, self%column, &
         & self%a, self%x, right)
   end subroutine solve

   !> Substitutes forwards and backwards.
   pure subroutine substitute(n, places, rows, columns, first, diagonal, column, a, x, right)
      integer, intent(in) :: n, places, rows(n), columns(n), first(n + 1), diagonal(n), column(places)
      real(wp), intent(in) :: a(places)
      real(wp), intent(inout) :: x(n), right(n)
      real(wp) :: left
      integer :: i, p
      do i = 1, n
         left = right(rows(i))
         do p = first(i), diagonal(i) - 1
            left = left - a(p)*x(column(p))
         end do
         x(i) = left
      end do
      do i = n, 1, -1
         left = x(i)
         do p = diagonal(i) + 1, first(i + 1) - 1
            left = left - a(p)*x(column(p))
         end do
         x(i) = left*a(diagonal(i))
         right(columns(i)) = x(i)
      end do
   end subroutine substitute

   !> The same with complex factors.
   pure subroutine solve_complex(self, right)
      class(small_lu_type), intent(inout) :: self
      complex(wp), contiguous, intent(inout) :: right(:)
      if (self%n > 0) call substitute_complex(self%n, size(self%column), self%rows, self%columns, self%first, self%diagonal, &
         & self%column, self%z(:, 1), self%z(:, 2), self%y(:, 1), self%y(:, 2), right)
   end subroutine solve_complex

   !> Substitutes complex numbers.
   pure subroutine substitute_complex(n, places, rows, columns, first, diagonal, column, a, b, x, y, right)
      integer, intent(in) :: n, places, rows(n), columns(n), first(n + 1), diagonal(n), column(places)
      real(wp), intent(in) :: a(places), b(places)
      real(wp), intent(inout) :: x(n), y(n)
      complex(wp), intent(inout) :: right(n)
      real(wp) :: s, t
      integer :: i, p
      do i = 1, n
         s = real(right(rows(i)), wp)
         t = aimag(right(rows(i)))
         do p = first(i), diagonal(i) - 1
            s = s - (a(p)*x(column(p)) - b(p)*y(column(p)))
            t = t - (a(p)*y(column(p)) + b(p)*x(column(p)))
         end do
         x(i) = s
         y(i) = t
      end do
      do i = n, 1, -1
         s = x(i)
         t = y(i)
         do p = diagonal(i) + 1, first(i + 1) - 1
            s = s - (a(p)*x(column(p)) - b(p)*y(column(p)))
            t = t - (a(p)*y(column(p)) + b(p)*x(column(p)))
         end do
         p = diagonal(i)
         x(i) = s*a(p) - t*b(p)
         y(i) = s*b(p) + t*a(p)
         right(columns(i)) = cmplx(x(i), y(i), wp)
      end do
   end subroutine substitute_complex

end module limber_multibody_small_sparse_lu
